"""Objects keep their ids from look to look."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st
from mbd_model.objects import SceneObject
from mbd_perception.features.tracking import TrackingConfig, lasting_ids

CONFIG = TrackingConfig()
small_move = st.tuples(st.floats(-0.03, 0.03), st.floats(-0.03, 0.03))


def on_grid(name: str, cell: tuple[int, int], hue: float | None = 10.0) -> SceneObject:
    """A cube on a grid wide enough that neighbours are never confused."""
    return SceneObject(name, (0.3 + 0.15 * cell[0], 0.15 * cell[1], 0.02), (0.04, 0.04, 0.04), hue=hue)


cells = st.lists(st.tuples(st.integers(0, 5), st.integers(-3, 3)), unique=True, max_size=12)


@given(cells, st.data())
def test_small_moves(places: list[tuple[int, int]], data: st.DataObject) -> None:
    """After small moves, and in whatever order they are seen, all objects keep their ids."""
    known = [on_grid(f"s{i}", cell) for i, cell in enumerate(places, start=1)]
    moved = []
    for obj in data.draw(st.permutations(known)):
        dx, dy = data.draw(small_move)
        moved.append(replace(obj, centroid=(obj.centroid[0] + dx, obj.centroid[1] + dy, 0.02)))
    assert lasting_ids(known, moved, "s", CONFIG) == tuple(o.object_id for o in moved)


@given(cells, cells)
def test_unique(before: list[tuple[int, int]], after: list[tuple[int, int]]) -> None:
    """Ids are never given twice, whatever came and went."""
    known = [on_grid(f"s{i}", cell) for i, cell in enumerate(before, start=1)]
    ids = lasting_ids(known, [on_grid("x", cell) for cell in after], "s", CONFIG)
    assert len(set(ids)) == len(after)


def test_new_and_gone() -> None:
    """A new object gets the lowest free number; one that left takes its id with it."""
    known = [on_grid("s1", (0, 0)), on_grid("s2", (1, 0)), on_grid("s3", (2, 0))]
    seen = [on_grid("a", (2, 0)), on_grid("b", (4, 2)), on_grid("c", (0, 0))]
    assert lasting_ids(known, seen, "s", CONFIG) == ("s3", "s2", "s1")


def test_first_look() -> None:
    """With nothing known, numbers are given in the order seen."""
    assert lasting_ids([], [on_grid("a", (0, 0)), on_grid("b", (1, 1))], "t", CONFIG) == ("t1", "t2")


def test_another_object_in_its_place() -> None:
    """An object of another size or colour in the same place is another object."""
    known = [on_grid("s1", (0, 0))]
    assert lasting_ids(known, [replace(known[0], size=(0.08, 0.08, 0.1))], "n", CONFIG) == ("n1",)
    assert lasting_ids(known, [replace(known[0], hue=120.0)], "n", CONFIG) == ("n1",)


def test_two_in_a_row_shift() -> None:
    """Two like objects that shift by less than their distance keep their order."""
    known = [
        SceneObject("s1", (0.50, 0.0, 0.02), (0.04, 0.04, 0.04)),
        SceneObject("s2", (0.545, 0.0, 0.02), (0.04, 0.04, 0.04)),
    ]
    seen = [replace(o, centroid=(o.centroid[0] + 0.03, 0.0, 0.02)) for o in known]
    assert lasting_ids(known, seen, "s", CONFIG) == ("s1", "s2")
