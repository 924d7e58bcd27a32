"""Frames as tf2 publishes them: chains compose as matrices do, and what is not connected has no pose."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from mbd_robot.frame_tree import FrameTransform, FrameTree
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation


def matrix(transform: FrameTransform) -> NDArray[np.float64]:
    made = np.eye(4)
    made[:3, :3] = Rotation.from_quat(transform.quaternion).as_matrix()
    made[:3, 3] = transform.position
    return made


def random_transform(rng: np.random.Generator, parent: str, stamp: float | None) -> FrameTransform:
    return FrameTransform(parent, rng.normal(size=3), Rotation.random(rng=rng).as_quat(), stamp)


@given(seed=st.integers(0, 10**6), up=st.integers(0, 4), down=st.integers(1, 5))
def test_a_frame_s_pose_in_another_is_the_product_on_the_way_through_what_they_share(seed: int, up: int, down: int):
    rng, tree = np.random.default_rng(seed), FrameTree()
    sides = []
    for side, length in (("base", up), ("tool", down)):
        product = np.eye(4)
        parent = "world"
        for k in range(length):
            name = side if k == length - 1 else f"{side}_{k}"
            made = random_transform(rng, parent, None if rng.random() < 0.3 else float(k))
            assert tree.put(name, made)
            product, parent = product @ matrix(made), name
        sides.append((parent, product))
    (base, to_base), (frame, to_frame) = sides
    found = tree.pose(base, frame)
    assert found is not None
    wanted = np.linalg.inv(to_base) @ to_frame
    assert np.allclose(found.pose.position, wanted[:3, 3], atol=1e-9)
    assert np.allclose(found.pose.rotation.as_matrix(), wanted[:3, :3], atol=1e-9)


def test_the_oldest_of_the_moving_ones_dates_the_pose():
    rng, tree = np.random.default_rng(1), FrameTree()
    tree.put("link_1", random_transform(rng, "base", 2.0))
    tree.put("link_2", random_transform(rng, "link_1", 1.0))
    tree.put("tool", random_transform(rng, "link_2", None))
    found = tree.pose("base", "tool")
    assert found is not None
    assert found.stamp == 1.0


def test_what_is_older_than_what_is_known_and_what_is_no_rotation_changes_nothing():
    rng, tree = np.random.default_rng(1), FrameTree()
    assert tree.put("tool", random_transform(rng, "base", 2.0))
    before = tree.pose("base", "tool")
    assert not tree.put("tool", random_transform(rng, "base", 1.0))
    assert not tree.put("tool", FrameTransform("base", np.zeros(3), np.zeros(4), 3.0))
    assert not tree.put("tool", FrameTransform("base", np.full(3, np.nan), np.array((0.0, 0, 0, 1)), 3.0))
    after = tree.pose("base", "tool")
    assert before is not None
    assert after is not None
    assert np.array_equal(before.pose.position, after.pose.position)


def test_what_is_not_connected_has_no_pose_and_a_circle_ends():
    rng, tree = np.random.default_rng(1), FrameTree()
    assert tree.pose("base", "tool") is None
    tree.put("/tool", random_transform(rng, "flange", 1.0))
    assert tree.pose("base", "tool") is None
    assert tree.chain("tool") == ("tool", "flange")
    tree.put("flange", random_transform(rng, "tool", 1.0))
    assert tree.pose("base", "tool") is None
