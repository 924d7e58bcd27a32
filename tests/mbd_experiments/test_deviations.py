"""Fitted standard deviations hold on errors they were not fitted to, and the truth those are measured from is true."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from mbd_experiments.perception_training import feature_errors_command, fit_deviations
from mbd_experiments.perception_training.deviation_model import coverage, fitted_weights
from mbd_experiments.perception_training.feature_errors import FeatureError, feature_error, room_errors
from mbd_experiments.perception_training.feature_truth import TrueFeatures, surface_points, true_features
from mbd_model.errors import MbdError
from mbd_model.objects import SceneObject
from mbd_perception.features.deviation_weights import WEIGHTS
from mbd_perception.features.deviations import DEVIATIONS
from mbd_perception.features.evidence_of_error import EVIDENCE
from mbd_perception.frames.evidence import save_frame
from mbd_perception.synthetic.casting import Box, Cylinder
from mbd_perception.synthetic.render import looking_at
from mbd_perception.synthetic.rooms import Kind, random_room

POSE = looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05))


def made_up(seed: int, count: int = 1500, wild: float = 0.0) -> list[FeatureError]:
    """Normal errors whose standard deviation depends on two things seen; a share of them ten times as large."""
    rng = np.random.default_rng(seed)
    evidence = rng.normal(0.0, 1.0, (count, len(EVIDENCE)))
    evidence[:, EVIDENCE.index("noise")] -= 20.0  # a quiet camera: more noise than was learned from makes std larger
    std = np.exp(-3.0 + 0.8 * evidence[:, 1] + 0.5 * evidence[:, 7])
    errors = rng.normal(0.0, 1.0, (count, len(DEVIATIONS))) * std[:, None]
    errors[:, DEVIATIONS.index("hue")] *= 100.0  # degrees
    errors[rng.random(count) < wild] *= 10.0
    return [FeatureError("room", row, off, owned=True, best=True) for row, off in zip(evidence, errors, strict=True)]


@pytest.mark.parametrize("wild", [0.0, 0.05])
def test_what_is_fitted_holds_on_others(wild: float) -> None:
    """Normal errors or some that are not: near 68 % within one and 95 % within two, and it tells objects apart."""
    weights = fitted_weights(made_up(0, wild=wild), ridge=1e-3)
    for c in coverage(made_up(1, wild=wild), weights):
        assert c.within_one == pytest.approx(0.683, abs=0.06 + wild), c.name
        assert c.within_two == pytest.approx(0.954, abs=0.03 + wild), c.name
        assert c.rank > 0.3, c.name


def test_what_has_no_truth_teaches_nothing() -> None:
    """Errors of unknown size change no other feature's weights; too few of one are refused by its name."""
    learned = made_up(0, 400)
    yaw = DEVIATIONS.index("yaw")
    blind = [
        replace(e, errors=np.where(np.arange(len(DEVIATIONS)) == yaw, np.nan, e.errors)) for e in learned[:200]
    ] + learned[200:]
    both = [fitted_weights(errors, 1e-3) for errors in (learned, blind)]
    others = np.delete(np.arange(2 + len(DEVIATIONS)), 2 + yaw)
    np.testing.assert_allclose(both[0][others], both[1][others])
    with pytest.raises(MbdError, match=r"only 0 objects have a true yaw.*--rooms"):
        fitted_weights(blind[:200], 1e-3)


def test_what_is_shipped_holds_in_rooms_it_was_not_fitted_to() -> None:
    """Of all errors of all features in four rooms about two thirds lie within one and nine tenths within two."""
    kinds = (Kind.PLAIN, Kind.MANY, Kind.KINECT_2, Kind.HOLES)
    errors = [error for kind in kinds for error in room_errors(kind, [4000], 1)]
    found = coverage(errors, WEIGHTS)
    counts = [c.count for c in found]
    assert sum(counts) > 150
    assert 0.55 < np.average([c.within_one for c in found], weights=counts) < 0.9
    assert np.average([c.within_two for c in found], weights=counts) > 0.85


def test_a_box_turned_by_a_quarter_is_the_same_box() -> None:
    """Its width is then its depth: neither yaw nor size is wrong."""
    size, center = (0.1, 0.06, 0.08), (0.6, 0.0, 0.04)
    measured = SceneObject("a", center, size, yaw=0.1, box_center=center, hue=359.0)
    true = TrueFeatures(np.array(center), np.array(center), (0.06, 0.1, 0.08), 0.1 - math.pi / 2, hue=2.0)
    off = dict(zip(DEVIATIONS, feature_error(measured, true, POSE), strict=True))
    assert off["hue"] == pytest.approx(-3.0)
    for name in ("yaw", "long", "short", "height", "volume"):
        assert off[name] == pytest.approx(0.0, abs=1e-9)


def test_errors_are_along_and_across_the_line_of_sight() -> None:
    """What is measured farther away than it is errs along it, upwards or not."""
    measured = SceneObject("a", (0.62, 0.0, 0.05), (0.1, 0.1, 0.1))
    off = feature_error(measured, TrueFeatures(np.array([0.6, 0.0, 0.04])), POSE)
    assert off[:3] == pytest.approx([0.02, 0.0, 0.01])
    assert np.isnan(off[3:]).all()


@pytest.mark.parametrize(
    "solid", [Box((0.5, 0.1, 0.02), (0.1, 0.06, 0.08), (9, 9, 9), 0.4), Cylinder((0.5, 0.1, 0.0), 0.04, 0.1, (9, 9, 9))]
)
def test_points_of_a_surface_lie_on_it(solid: Box | Cylinder) -> None:
    """Within its reach, the top among them, their middle above the middle of the foot."""
    points = surface_points(solid) - np.asarray(solid.foot)
    radius, height = solid.reach
    assert np.hypot(points[:, 0], points[:, 1]).max() <= radius + 1e-9
    assert points[:, 2].max() == pytest.approx(height)
    assert points[:, 2].min() > 0
    np.testing.assert_allclose(points[:, :2].mean(axis=0), 0.0, atol=2e-3)


def test_the_true_centroid_is_that_of_what_is_seen() -> None:
    """It lies within the thing, in its half nearer to the camera."""
    room = random_room(Kind.PLAIN, np.random.default_rng(3))
    for number in np.unique(room.truth)[1:]:
        true, solid = true_features(room, int(number), coloured=True), room.solids[number - 1]
        off = true.centroid - np.asarray(solid.foot)
        assert np.hypot(*off[:2]) < solid.reach[0] and 0 < off[2] <= solid.reach[1] + 1e-6
        assert np.linalg.norm(true.centroid - room.view.pose.position) < np.linalg.norm(
            np.asarray(solid.foot) - room.view.pose.position
        )


def test_the_commands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`fit_deviations` writes weights that load again, `feature_errors` a table by set; a folder without truth is
    refused by both.
    """
    room = random_room(Kind.PLAIN, np.random.default_rng(3))
    folder = tmp_path / "frame"
    folder.mkdir()
    save_frame(folder, room.view.frame)
    with pytest.raises(SystemExit):
        feature_errors_command.main(["--set", "mine", str(folder), "--rooms", "0"])
    with pytest.raises(SystemExit):
        fit_deviations.main([str(folder)])
    assert "labels.png is missing" in capsys.readouterr().err
    cv2.imwrite(str(folder / "labels.png"), np.where(room.truth > 0, room.truth + 1, 0).astype(np.uint8))
    assert feature_errors_command.main(["--set", "mine", str(folder), "--rooms", "0"]) == 0
    assert "| mine | " in capsys.readouterr().out
    out = tmp_path / "weights.py"
    assert fit_deviations.main([str(folder), "--rooms", "1", "--apart", "0", "--out", str(out), "--jobs", "1"]) == 0
    names: dict[str, np.ndarray] = {}
    exec(out.read_text(), names)
    assert names["WEIGHTS"].shape == WEIGHTS.shape
    assert max(len(line) for line in out.read_text().splitlines()) <= 120
