"""Objects stand apart, in reach and in view, whatever the seed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_cell.layout.placement import MAX_REACH, layout, place_in_rows, place_randomly, reserved_spots
from mbd_cell.layout.scenes import ObjectSpec, Shape
from mbd_cell.physics.camera import INTRINSICS
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from shipped_scenes import TASKS, scenes_of

tables = st.tuples(st.sampled_from(TASKS), st.sampled_from(list(Role)), st.integers(0, 2**31 - 1))


@given(tables)
def test_objects_leave_five_centimetres_between_them(table: tuple[str, Role, int]) -> None:
    task, role, seed = table
    objects, places = scenes_of(task).objects(role), layout(scenes_of(task), role, seed)
    for i, (a, p) in enumerate(zip(objects, places, strict=True)):
        for b, q in list(zip(objects, places, strict=True))[:i]:
            gap = math.hypot(p.x - q.x, p.y - q.y) - a.footprint_radius - b.footprint_radius
            assert gap > 0.05, f"{a.name} and {b.name} of {table} are {gap:.3f} m apart"


@given(tables)
def test_objects_stand_within_the_arms_reach(table: tuple[str, Role, int]) -> None:
    task, role, seed = table
    assert all(math.hypot(p.x, p.y) <= MAX_REACH for p in layout(scenes_of(task), role, seed))


@given(tables)
def test_the_camera_sees_every_object_complete(table: tuple[str, Role, int]) -> None:
    task, role, seed = table
    for thing, place in zip(scenes_of(task).objects(role), layout(scenes_of(task), role, seed), strict=True):
        r = thing.footprint_radius
        for dx, dy, height in [(a, b, h) for a in (-r, r) for b in (-r, r) for h in (0.0, thing.size[2])]:
            seen = CELL_CAMERA.rotation.T @ (np.array([place.x + dx, place.y + dy, height]) - CELL_CAMERA.position)
            u = INTRINSICS.fx * seen[0] / seen[2] + INTRINSICS.cx
            v = INTRINSICS.fy * seen[1] / seen[2] + INTRINSICS.cy
            assert 0 <= u < INTRINSICS.width and 0 <= v < INTRINSICS.height, f"{thing.name} of {table} at ({u}, {v})"


@given(tables)
def test_the_same_seed_gives_the_same_layout(table: tuple[str, Role, int]) -> None:
    task, role, seed = table
    assert layout(scenes_of(task), role, seed) == layout(scenes_of(task), role, seed)


def test_another_seed_gives_another_layout() -> None:
    for task in TASKS:
        assert layout(scenes_of(task), Role.SOURCE, 1) != layout(scenes_of(task), Role.SOURCE, 2)


@given(st.integers(0, 2**31 - 1))
def test_what_the_demonstration_sets_on_the_table_finds_its_place_free(seed: int) -> None:
    scenes = scenes_of("assembly")
    spots = reserved_spots(scenes)
    assert spots
    for thing, place in zip(scenes.source, layout(scenes, Role.SOURCE, seed), strict=True):
        for x, y, radius in spots:
            assert math.hypot(place.x - x, place.y - y) > thing.footprint_radius + radius + 0.02


def test_a_table_too_full_is_refused_with_the_names_of_what_does_not_fit() -> None:
    crowd = [ObjectSpec(f"plate_{i}", Shape.BOWL, (0.3, 0.3, 0.05), None, 0.2) for i in range(6)]
    with pytest.raises(MbdError, match="plate_5"):
        place_randomly(crowd, np.random.default_rng(1), attempts=20)
    with pytest.raises(MbdError, match="scattered"):
        place_in_rows([*crowd, *crowd], np.random.default_rng(1))
