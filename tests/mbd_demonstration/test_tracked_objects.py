"""Objects are followed through what the demonstration does to them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_demonstration.config import StepSegmentationConfig
from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_demonstration.trajectory import ToolPose
from mbd_model.objects import Role, Scene, SceneObject

DOWN = np.array([1.0, 0.0, 0.0, 0.0])
SCENE = Scene(
    Role.SOURCE,
    (
        SceneObject("bowl", (0.5, 0.0, 0.03), (0.12, 0.12, 0.06)),
        SceneObject("cup", (0.5, 0.3, 0.05), (0.06, 0.06, 0.1)),
        SceneObject("spoon", (0.3, 0.3, 0.01), (0.02, 0.15, 0.02)),
    ),
)


def pose(x: float, y: float, z: float, turn: float = 0.0) -> ToolPose:
    """The hand pointing down, turned about the vertical [rad]."""
    return ToolPose(np.array([x, y, z]), np.array([math.cos(turn / 2), math.sin(turn / 2), 0.0, 0.0]))


def test_what_stands_on_a_moved_object_moves_with_it():
    """The cup put into the bowl rides along when the bowl is moved."""
    workspace = (
        TrackedObjects.before(SCENE).carried("cup", pose(0.5, 0.3, 0.1), pose(0.5, 0.0, 0.11)).put_onto("cup", "bowl")
    )
    moved = workspace.carried("bowl", pose(0.5, 0.06, 0.06), pose(0.3, -0.14, 0.06))
    np.testing.assert_allclose(moved["cup"].centroid, (0.3, -0.2, 0.06), atol=1e-9)
    assert moved["spoon"] == SCENE["spoon"]


def test_what_was_taken_off_again_stays_behind():
    on = TrackedObjects.before(SCENE).carried("cup", pose(0.5, 0.3, 0.1), pose(0.5, 0.0, 0.11)).put_onto("cup", "bowl")
    off = on.carried("cup", pose(0.5, 0.0, 0.11), pose(0.2, 0.0, 0.1))
    assert off.load("bowl") == {"bowl"}


@given(x=st.floats(-0.5, 0.5), y=st.floats(-0.5, 0.5), turn=st.floats(-3.1, 3.1))
def test_carrying_there_and_back_changes_nothing(x, y, turn):
    there, here = pose(x, y, 0.3, turn), pose(0.5, 0.3, 0.1)
    back = TrackedObjects.before(SCENE).carried("cup", here, there).carried("cup", there, here)
    np.testing.assert_allclose(back["cup"].centroid, SCENE["cup"].centroid, atol=1e-9)
    assert math.remainder(back["cup"].yaw - SCENE["cup"].yaw, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_turning_the_hand_turns_the_box_it_holds():
    turned = TrackedObjects.before(SCENE).carried("spoon", pose(0.3, 0.3, 0.02), pose(0.3, 0.3, 0.02, math.pi / 2))
    assert abs(turned["spoon"].yaw) == pytest.approx(math.pi / 2)
    np.testing.assert_allclose(turned["spoon"].centroid, SCENE["spoon"].centroid, atol=1e-9)


@pytest.mark.parametrize(("y", "expected"), [(0.0, {"bowl"}), (0.07, {"bowl"}), (0.10, set())])
def test_an_object_is_put_onto_what_its_centre_is_over(y: float, expected: set[str]):
    released = TrackedObjects.before(SCENE).carried("cup", pose(0.5, 0.3, 0.1), pose(0.5, y, 0.16))
    assert released.receivers("cup", StepSegmentationConfig()) == expected


def test_an_object_high_above_another_is_not_put_onto_it():
    released = TrackedObjects.before(SCENE).carried("cup", pose(0.5, 0.3, 0.1), pose(0.5, 0.0, 0.30))
    assert released.receivers("cup", StepSegmentationConfig()) == set()
