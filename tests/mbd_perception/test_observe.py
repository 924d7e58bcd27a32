"""A look at a synthetic table finds what stands on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_model.objects import Relation, Role
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import NoObjectError, ObserveConfig, observe
from mbd_perception.frames.frame import fuse
from mbd_perception.segmentation.segment import SegmentationConfig
from mbd_perception.segmentation.table.plane import NoTableError
from mbd_perception.segmentation.workspace import Workspace
from mbd_perception.synthetic.render import Box, Cylinder, Table, looking_at, render

KNOWLEDGE = Path(__file__).parents[2] / "ros2_ws/src/mbd_perception/config/knowledge.yaml"
CONFIG = ObserveConfig(
    knowledge=load_knowledge(KNOWLEDGE),
    segmentation=SegmentationConfig(workspace=Workspace(x=(0.25, 1.3), y=(-0.7, 0.7), z=(-0.05, 0.5))),
)
OVERHEAD = looking_at((0.6, 0.0, 1.1), (0.6, 0.0, 0.0))
SLANTED = looking_at((0.0, 0.0, 0.7), (0.65, 0.0, 0.0))
RED, GREEN, BLUE = (200, 40, 40), (40, 200, 40), (40, 40, 200)


def place(column: int, row: int) -> tuple[float, float, float]:
    """A place on a grid on which objects do not touch [m]."""
    return 0.45 + 0.16 * row, 0.3 - 0.2 * column, 0.0


@st.composite
def tables(draw: st.DrawFn) -> list[Box | Cylinder]:
    """One to seven separate boxes and cups."""
    cells = draw(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 2)), min_size=1, max_size=7, unique=True))
    solids: list[Box | Cylinder] = []
    for cell in cells:
        color = draw(st.sampled_from((RED, GREEN, BLUE)))
        if draw(st.booleans()):
            size = (draw(st.floats(0.04, 0.1)), draw(st.floats(0.04, 0.1)), draw(st.floats(0.02, 0.08)))
            solids.append(Box(place(*cell), size, color, draw(st.floats(-0.7, 0.7))))
        else:
            solids.append(
                Cylinder(place(*cell), draw(st.floats(0.025, 0.05)), draw(st.floats(0.02, 0.08)), color, wall=0.004)
            )
    return solids


@settings(max_examples=12, deadline=None)
@given(tables(), st.sampled_from((OVERHEAD, SLANTED)), st.integers(0, 1000))
def test_every_object_found(solids: list[Box | Cylinder], pose: object, seed: int) -> None:
    """Every separate object is found once, near where it stands, with its height."""
    view = render(solids, pose, np.random.default_rng(seed))  # type: ignore[arg-type]  # hypothesis loses the type
    scene = observe(view.frame, Role.SOURCE, view.pose, CONFIG).scene
    assert len(scene.objects) == len(solids)
    for solid in solids:
        distance = [np.hypot(o.centroid[0] - solid.foot[0], o.centroid[1] - solid.foot[1]) for o in scene.objects]
        nearest = scene.objects[int(np.argmin(distance))]
        height = solid.size[2] if isinstance(solid, Box) else solid.height
        assert min(distance) < 0.03
        assert abs(nearest.size[2] - height) < 0.008


def test_features() -> None:
    """Size, turn, hue, class and relations of known objects come out right."""
    solids = [
        Cylinder((0.6, 0.2, 0.0), 0.04, 0.1, RED, wall=0.003),
        Cylinder((0.6, -0.1, 0.0), 0.06, 0.05, BLUE, wall=0.003),
        Box((0.5, 0.05, 0.0), (0.02, 0.15, 0.018), GREEN, yaw=0.3),
        Box((0.8, -0.3, 0.0), (0.052, 0.084, 0.039), (200, 200, 200), yaw=-0.5),
    ]
    rng = np.random.default_rng(1)
    frames = [render(solids, OVERHEAD, rng, stamp=t).frame for t in (1.0, 2.0, 3.0)]
    scene = observe(fuse(frames), Role.TARGET, OVERHEAD, CONFIG).scene
    assert scene.ids == ("t1", "t2", "t3", "t4")
    assert scene.stamp == 3.0
    cup, spoon, bowl, block = scene.objects
    assert [o.object_class for o in scene.objects] == ["cup", "utensil", "bowl", "block"]
    assert [o.color_name for o in scene.objects] == ["red", "green", "blue", "white"]
    assert block.hue is None
    assert cup.hue == pytest.approx(0.0, abs=3) or cup.hue == pytest.approx(360.0, abs=3)
    assert bowl.affordances == {"fillable", "stackable"}
    assert spoon.yaw == pytest.approx(0.3, abs=0.05)
    assert spoon.size == pytest.approx((0.15, 0.02, 0.018), abs=0.006)
    assert block.size == pytest.approx((0.084, 0.052, 0.039), abs=0.006)
    assert block.yaw == pytest.approx(-0.5, abs=0.06)
    assert {(Relation.LEFT_OF, "t3"), (Relation.LEFT_OF, "t4")} <= set(cup.relations)
    assert (Relation.RIGHT_OF, "t1") in bowl.relations


def test_same_frame_same_scene() -> None:
    """The same frame always gives the same scene."""
    view = render([Box((0.6, 0.0, 0.0), (0.05, 0.05, 0.05), RED)], SLANTED, np.random.default_rng(3))
    first, second = (observe(view.frame, Role.SOURCE, SLANTED, CONFIG).scene for _ in range(2))
    assert first == second


def test_wall_and_floor() -> None:
    """A wall behind the table and the floor below it are no table and no objects."""
    pose = looking_at((-0.2, 0.0, 0.8), (0.8, 0.0, 0.1))
    table = Table(x=(0.3, 1.2), y=(-0.45, 0.45), floor_z=-0.7, wall_x=1.8)
    solids = [Box((0.7, 0.1, 0.0), (0.1, 0.1, 0.1), RED), Cylinder((0.9, -0.2, 0.0), 0.05, 0.2, BLUE)]
    view = render(solids, pose, np.random.default_rng(4), table=table)
    assert len(observe(view.frame, Role.SOURCE, pose, CONFIG).scene.objects) == 2


def test_arm_left_out() -> None:
    """What reaches in from outside the workspace is no object, and an object beside it still is."""
    arm = Box((0.25, 0.0, 0.15), (0.5, 0.08, 0.08), (60, 60, 60))
    block = Box((0.7, 0.2, 0.0), (0.06, 0.06, 0.06), RED)
    view = render([arm, block], OVERHEAD, np.random.default_rng(5))
    result = observe(view.frame, Role.SOURCE, OVERHEAD, CONFIG)
    assert len(result.scene.objects) == 1
    assert result.segmentation.left_out == 1


def test_arm_alone() -> None:
    """When only the arm is in view the message states that something was left out."""
    arm = Box((0.25, 0.0, 0.15), (0.5, 0.08, 0.08), (60, 60, 60))
    view = render([arm], OVERHEAD, np.random.default_rng(5))
    with pytest.raises(NoObjectError, match="reach out of the workspace"):
        observe(view.frame, Role.SOURCE, OVERHEAD, CONFIG)


def test_empty_table() -> None:
    """An empty table is reported as such."""
    view = render([], SLANTED, np.random.default_rng(6))
    with pytest.raises(NoObjectError, match="nothing stands on it"):
        observe(view.frame, Role.SOURCE, SLANTED, CONFIG)


def test_no_table() -> None:
    """A camera that sees no flat surface reports it."""
    solids = [Cylinder((0.6 + 0.05 * (i % 7), -0.3 + 0.05 * (i // 7), 0.0), 0.02, 0.1, RED) for i in range(70)]
    nowhere = Table(x=(5.0, 5.1), y=(5.0, 5.1))
    view = render(solids, SLANTED, np.random.default_rng(7), table=nowhere)
    with pytest.raises(NoTableError, match="no table in view"):
        observe(view.frame, Role.SOURCE, SLANTED, CONFIG)


def test_tilted_table() -> None:
    """A camera pose that is wrong by 30 degrees is reported as a tilted table."""
    view = render([Box((0.6, 0.0, 0.0), (0.1, 0.1, 0.1), RED)], SLANTED, np.random.default_rng(8))
    wrong = looking_at((0.0, 0.0, 0.7), (2.6, 0.0, 0.0))
    config = ObserveConfig(knowledge=CONFIG.knowledge)
    with pytest.raises(NoTableError, match="tilted"):
        observe(view.frame, Role.SOURCE, wrong, config)


def test_unknown_pose() -> None:
    """Without a camera pose the objects come in a frame whose z = 0 is the table."""
    view = render([Box((0.6, 0.1, 0.0), (0.06, 0.1, 0.08), RED)], SLANTED, np.random.default_rng(9))
    observation = observe(view.frame, Role.SOURCE, None, CONFIG)
    (box,) = observation.scene.objects
    assert box.size[2] == pytest.approx(0.08, abs=0.006)
    assert 0.0 < box.centroid[2] < 0.08
    assert observation.table_in_base == pytest.approx((0, 0, 1, 0), abs=1e-6)
