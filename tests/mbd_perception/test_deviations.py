"""What is stated of how exactly an object was measured: for every feature, larger where less can be seen."""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np
import pytest
from mbd_model.camera.pose import CameraPose
from mbd_model.objects import FeatureDeviations, Role, SceneObject
from mbd_perception.features.deviation_weights import WEIGHTS
from mbd_perception.features.deviations import DEVIATIONS, predicted
from mbd_perception.features.evidence_of_error import EVIDENCE, outlines
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import ObserveConfig, observe
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.synthetic.casting import Solid
from mbd_perception.synthetic.render import Box, Table, looking_at, render
from mbd_perception.synthetic.rooms import Kind, furnished, photographed, random_room

KNOWLEDGE = load_knowledge(Path(__file__).parents[2] / "ros2_ws/src/mbd_perception/config/knowledge.yaml")
CONFIG = ObserveConfig(knowledge=KNOWLEDGE)
RED, BLUE = (200, 40, 40), (40, 40, 200)
WIDE = Table(x=(-1.0, 3.0), y=(-1.5, 1.5))


def seen(solids: list[Solid], pose: CameraPose, noise: float = 1.5e-3) -> list[SceneObject]:
    """The objects, from left to right."""
    frame = render(solids, pose, np.random.default_rng(0), table=WIDE, noise=noise).frame
    return list(observe(frame, Role.SOURCE, pose, CONFIG).scene.objects)


def stated(obj: SceneObject) -> FeatureDeviations:
    """Its deviations, which every observed object has."""
    assert obj.deviations is not None
    return obj.deviations


def test_the_weights_are_those_of_the_evidence() -> None:
    """A bias and a weight for all that is looked at, for every deviation, below the range of what was learned."""
    assert WEIGHTS.shape == (2 + len(DEVIATIONS), 1 + len(EVIDENCE))
    assert (WEIGHTS[0, 1:] <= WEIGHTS[1, 1:]).all()


@pytest.mark.parametrize("kind", [Kind.PLAIN, Kind.GREY, Kind.HOLES])
def test_every_observed_object_has_them(kind: Kind) -> None:
    """All positive; of the hue only where there is one."""
    room = random_room(kind, np.random.default_rng([zlib.crc32(kind.name.encode()), 77]))
    for pose in (room.view.pose, None):
        for obj in observe(room.view.frame, Role.TARGET, pose, CONFIG).scene.objects:
            std = stated(obj)
            single = (std.yaw, std.volume, std.saturation, *([] if std.hue is None else [std.hue]))
            assert all(v > 0 for v in (*std.centroid, *std.box_center, *std.size, *single))
            assert (std.hue is None) == (obj.hue is None)


def test_two_views_differ_as_the_deviations_of_both_say() -> None:
    """The same rooms from two places: of the differences of what does not depend on the view most lie within two."""
    shares = []
    for number in range(3):
        rng = np.random.default_rng([91, number])
        room = furnished(Kind.PLAIN, rng)
        views = [photographed(room, rng) for _ in range(2)]
        first, second = (observe(v.view.frame, Role.SOURCE, v.view.pose, CONFIG).scene.objects for v in views)
        for a in first:
            b = min(second, key=lambda o: float(np.linalg.norm(np.subtract(o.box_center, a.box_center))))
            if np.linalg.norm(np.subtract(b.box_center, a.box_center)) > 0.04 or a.hue is None or b.hue is None:
                continue
            one, other = stated(a), stated(b)
            gaps = (*np.subtract(a.box_center, b.box_center), a.size[2] - b.size[2], np.log(a.volume / b.volume))
            stds = (
                *np.hypot(one.box_center, other.box_center),
                np.hypot(one.size[2], other.size[2]),
                np.hypot(one.volume / a.volume, other.volume / b.volume),
            )
            shares += list(np.abs(gaps) / stds)
    assert len(shares) > 40
    assert np.mean(np.array(shares) < 2.0) > 0.85
    assert np.mean(np.array(shares) > 0.25) > 0.4


def test_a_thing_far_away_is_measured_less_exactly() -> None:
    """The same box at 2 m against 0.6 m, and with a noisy camera against a good one."""
    box: list[Solid] = [Box((0.7, 0.0, 0.0), (0.08, 0.08, 0.1), RED)]
    (near,) = seen(box, looking_at((0.1, 0.0, 0.5), (0.7, 0.0, 0.0)))
    (far,) = seen(box, looking_at((-0.7, 0.0, 1.2), (0.7, 0.0, 0.0)))
    assert stated(far).size[2] > stated(near).size[2]
    assert stated(far).volume / far.volume > stated(near).volume / near.volume
    (noisy,) = seen(box, looking_at((0.1, 0.0, 0.5), (0.7, 0.0, 0.0)), noise=6e-3)
    assert stated(noisy).size[2] > stated(near).size[2]


def test_a_thing_half_hidden_is_measured_less_exactly() -> None:
    """A box behind another one, and the same alone."""
    pose = looking_at((-0.1, 0.0, 0.45), (0.7, 0.0, 0.05))
    behind = Box((0.8, 0.0, 0.0), (0.08, 0.16, 0.12), RED)
    before = Box((0.6, 0.06, 0.0), (0.05, 0.08, 0.11), BLUE)
    (alone,) = seen([behind], pose)
    hidden = next(o for o in seen([before, behind], pose) if o.color_name == "red")
    assert max(stated(hidden).size[:2]) > max(stated(alone).size[:2])
    assert max(stated(hidden).box_center[:2]) > max(stated(alone).box_center[:2])


def test_the_outline_is_told_apart() -> None:
    """What stands before a thing hides part of its outline; of the one before nothing is hidden."""
    pose = looking_at((-0.1, 0.0, 0.45), (0.7, 0.0, 0.05))
    solids: list[Solid] = [
        Box((0.6, 0.06, 0.0), (0.05, 0.08, 0.11), BLUE),
        Box((0.8, 0.0, 0.0), (0.08, 0.16, 0.12), RED),
    ]
    frame = render(solids, pose, np.random.default_rng(0), table=WIDE).frame
    found = segment(frame, pose, SegmentationConfig())
    along = outlines(frame, found)
    red = [int(found.labels[(frame.color[..., 0] > 100) & (found.labels > 0) & (frame.color[..., 2] < 90)].max())]
    blue = [k for k in range(1, found.count + 1) if k not in red]
    assert along.hidden[red].min() > 0.1
    assert along.hidden[blue].max() < 0.05


def test_deviations_turn_with_the_line_of_sight() -> None:
    """Seen along y instead of along x, the deviations along x and y change places."""
    box: list[Solid] = [Box((0.7, 0.0, 0.0), (0.1, 0.1, 0.1), RED)]
    (along_x,) = seen(box, looking_at((-0.1, 0.0, 0.6), (0.7, 0.0, 0.0)))
    (along_y,) = seen(box, looking_at((0.7, -0.8, 0.6), (0.7, 0.0, 0.0)))
    for one, other in zip(stated(along_x).box_center, np.array(stated(along_y).box_center)[[1, 0, 2]], strict=True):
        assert one == pytest.approx(other, rel=0.15)


def test_more_noise_than_was_learned_from_counts_in_proportion() -> None:
    """Twice the noise, twice the deviation, except of colours; and nothing falls before."""
    evidence = WEIGHTS[:2, 1:].mean(axis=0)
    distance, noise = EVIDENCE.index("distance"), EVIDENCE.index("noise")
    evidence[distance] = np.log(0.9)
    growing = [DEVIATIONS.index(name) for name in DEVIATIONS if name not in ("hue", "saturation")]
    rows = np.array([evidence] * 2)
    rows[:, noise] = np.log(np.array([3.7e-3, 7.4e-3]) * 0.9**2)
    std = predicted(rows)
    np.testing.assert_allclose(std[1, growing], 2 * std[0, growing], rtol=0.01)
    assert (std[1] >= std[0]).all()


@pytest.mark.parametrize("noise", [3e-3, 7.4e-3])
def test_a_noisy_camera_is_owned_up_to(noise: float) -> None:
    """Boxes look larger in noise; of their sides and volumes most are within two deviations all the same."""
    rng, gaps = np.random.default_rng(11), []
    boxes: list[Solid] = [
        Box((0.65, y, 0.0), (0.06, 0.09, 0.1), color, 0.4)
        for y, color in ((-0.2, RED), (0.0, BLUE), (0.2, (40, 160, 60)))
    ]
    for _ in range(4):
        pose = looking_at((rng.uniform(-0.3, 0.1), rng.uniform(-0.3, 0.3), rng.uniform(0.6, 0.9)), (0.7, 0.0, 0.0))
        for obj in seen(boxes, pose, noise):
            sides, std = sorted(obj.size[:2]), stated(obj)
            gaps += list(np.abs(np.subtract(sides, (0.06, 0.09))) / min(std.size[:2]))
            gaps.append(abs(obj.volume - 0.06 * 0.09 * 0.1) / std.volume)
    assert len(gaps) > 30
    assert np.mean(np.array(gaps) < 2.0) >= 0.85


def test_nothing_else_is_extrapolated() -> None:
    """Evidence beyond what was learned from counts as the outermost that was."""
    middle = WEIGHTS[:2, 1:].mean(axis=0)
    beyond, outermost = middle.copy(), middle.copy()
    beyond[0], outermost[0] = WEIGHTS[1, 1] + 100.0, WEIGHTS[1, 1]
    np.testing.assert_array_equal(predicted(beyond[None]), predicted(outermost[None]))
