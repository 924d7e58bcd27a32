"""Spatial relations follow from extents."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st
from mbd_model.geometry.spatial import extents, relations_between, spatial_relations
from mbd_model.objects import Relation, SceneObject

OPPOSITE = {
    Relation.LEFT_OF: Relation.RIGHT_OF,
    Relation.RIGHT_OF: Relation.LEFT_OF,
    Relation.ABOVE: Relation.BELOW,
    Relation.BELOW: Relation.ABOVE,
}
coordinate = st.floats(-1.0, 1.0)
length = st.floats(0.01, 0.5)


def block(name: str, x: float, y: float, *, width: float = 0.1, depth: float = 0.1, yaw: float = 0.0) -> SceneObject:
    """A block standing there [m]."""
    return SceneObject(name, (x, y, 0.0), (width, depth, 0.1), yaw=yaw)


blocks = st.builds(
    block, st.just("i"), coordinate, coordinate, width=length, depth=length, yaw=st.floats(-math.pi, math.pi)
)


@given(blocks, blocks)
def test_opposite(i: SceneObject, j: SceneObject) -> None:
    """The relations seen from the other object are the opposite ones."""
    assert relations_between(i, j) == tuple(OPPOSITE[r] for r in relations_between(j, i))


def test_directions() -> None:
    """Left is positive y and above is away from the robot."""
    here = block("here", 0.5, 0.0)
    assert relations_between(block("a", 0.5, 0.2), here) == (Relation.LEFT_OF,)
    assert relations_between(block("a", 0.5, -0.2), here) == (Relation.RIGHT_OF,)
    assert relations_between(block("a", 0.7, 0.0), here) == (Relation.ABOVE,)
    assert relations_between(block("a", 0.3, 0.0), here) == (Relation.BELOW,)


def test_overlap() -> None:
    """Objects whose extents overlap in both axes have no relation."""
    assert relations_between(block("a", 0.5, 0.0), block("b", 0.55, 0.05)) == ()


def test_both_axes() -> None:
    """An object that is apart in both axes stands in both relations."""
    both = relations_between(block("a", 0.9, 0.4), block("b", 0.5, 0.0))
    assert both == (Relation.LEFT_OF, Relation.ABOVE)


def test_quarter_turn() -> None:
    """A quarter turn swaps width and depth."""
    near, far, right, left = extents(block("a", 0.0, 0.0, width=0.4, depth=0.1, yaw=math.pi / 2))
    assert math.isclose(far - near, 0.4)
    assert math.isclose(left - right, 0.1)


def test_a_row_of_objects() -> None:
    """Objects side by side stand in one relation each, overlapping ones in none."""
    objects = [block("a", 0.5, 0.3), block("b", 0.5, 0.0), block("c", 0.5, 0.02)]
    a, b, c = spatial_relations(objects)
    assert a == ((Relation.LEFT_OF, "b"), (Relation.LEFT_OF, "c"))
    assert b == ((Relation.RIGHT_OF, "a"),)
    assert c == ((Relation.RIGHT_OF, "a"),)
