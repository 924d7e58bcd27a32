"""Somebody who disturbs: what he does to the table, by himself and from a seed, and what he leaves alone."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from mbd_cell.adversary import Adversary, TableDisturbance
from mbd_cell.cell import Cell
from mbd_cell.layout.object_sets import drawn_scenes
from mbd_cell.layout.scenes import ObjectSpec, Shape
from mbd_cell.outcome import ObjectState, object_states
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.physics.displacing import put
from mbd_model.objects import Role
from shipped_scenes import scenes_of

SPARE = ObjectSpec("spare", Shape.BOX, (0.07, 0.044, 0.034), 200.0, 0.06)
CUPS = ("violet_cup", "green_cup", "magenta_cup", "teal_cup", "blue_cup")


def laid(seed: int) -> Cell:
    """Stacking's target set on the table, at rest."""
    scenes = replace(drawn_scenes(scenes_of("stacking"), seed), spares=(SPARE,))
    cell = Cell(scenes, seed, CELL_CAMERA)
    cell.lay(Role.TARGET, seed)
    for _ in range(60):
        cell.tick()
    return cell


def disturb(
    cell: Cell, *what: TableDisturbance, seed: int = 1, wanted: tuple[str, ...] = CUPS
) -> tuple[Adversary, dict[str, ObjectState], dict[str, ObjectState]]:
    """He acts until he has done it or cannot; with the objects before and after."""
    before = object_states(cell.simulation)
    adversary = Adversary(cell, what, np.random.default_rng(seed))
    for _ in what:
        for _ in adversary.act(wanted):
            cell.tick()
    for _ in range(60):
        cell.tick()
    return adversary, before, object_states(cell.simulation)


def moved(before: dict[str, ObjectState], after: dict[str, ObjectState]) -> dict[str, float]:
    """How far each object has gone along the table [m], of those that did."""
    way = {n: math.dist(before[n].pose.position[:2], after[n].pose.position[:2]) for n in before}
    return {n: d for n, d in way.items() if d > 0.003}


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_a_pushed_object_stands_5_cm_farther_and_all_others_where_they_stood(seed: int):
    adversary, before, after = disturb(laid(seed), TableDisturbance.PUSH, seed=seed)
    (pushed,) = adversary.done
    assert moved(before, after) == {pushed.name: pytest.approx(0.05, abs=0.006)}
    assert after[pushed.name].lean < 0.02


@pytest.mark.parametrize("seed", [2, 5])
def test_two_that_changed_places_stand_where_the_other_stood(seed: int):
    adversary, before, after = disturb(laid(seed), TableDisturbance.SWAP, seed=seed)
    one, other = sorted(moved(before, after))
    assert one in adversary.done[0].words and other in adversary.done[0].words
    assert after[one].pose.position[:2] == pytest.approx(before[other].pose.position[:2], abs=0.003)
    assert after[other].pose.position[:2] == pytest.approx(before[one].pose.position[:2], abs=0.003)


@pytest.mark.parametrize("what", [TableDisturbance.TAKE, TableDisturbance.KNOCK])
@pytest.mark.parametrize("seed", [2, 5])
def test_what_he_took_or_knocked_over_is_not_upright_on_the_table_until_he_is_asked_to_put_it_right(what, seed: int):
    cell = laid(seed)
    adversary, before, after = disturb(cell, what, seed=seed)
    name = adversary.done[0].name
    assert after[name].lean > 1.0 or after[name].top < -0.3
    assert adversary.put_right(["nothing of the kind"]) == ()
    assert adversary.put_right([name]) == (name,)
    for _ in range(60):
        cell.tick()
    now = object_states(cell.simulation)[name]
    assert now.lean < 0.02 and now.bottom == pytest.approx(before[name].bottom, abs=0.003)
    assert adversary.put_right([name]) == ()


def test_what_he_is_asked_to_put_onto_another_lands_on_it_upright_and_what_he_puts_back_stands_where_it_stood():
    cell = laid(2)
    adversary, before, _ = disturb(cell)
    home = before["blue_cup"].pose.position
    assert adversary.put_back("blue_cup") == ()
    for offset in ((0.0, 0.0), (0.01, 0.0)):
        assert adversary.put_onto("blue_cup", "violet_cup", offset) == ("blue_cup",)
        for _ in range(80):
            cell.tick()
        now = object_states(cell.simulation)["blue_cup"]
        assert math.dist(now.pose.position[:2], before["violet_cup"].pose.position[:2]) < 0.02
        assert now.lean < 0.3 and now.bottom > 0.002
    assert adversary.put_back("blue_cup") == ("blue_cup",)
    assert cell.simulation.object_pose("blue_cup").position == pytest.approx(home, abs=1e-6)
    assert adversary.put_onto("nothing of the kind", "violet_cup", (0.0, 0.0)) == ()


def test_what_he_adds_stands_on_the_table_clear_of_everything():
    _, before, after = disturb(laid(2), TableDisturbance.ADD)
    assert list(moved(before, after)) == ["spare"]
    assert after["spare"].bottom == pytest.approx(0.0, abs=0.002)
    apart = [math.dist(after["spare"].pose.position[:2], after[n].pose.position[:2]) for n in CUPS]
    assert min(apart) > 0.04 + SPARE.footprint_radius


def test_he_does_the_same_again_from_the_same_seed_and_each_thing_once():
    what = (TableDisturbance.PUSH, TableDisturbance.ADD)
    (one, _, first), (other, _, second) = (disturb(laid(2), *what, seed=7) for _ in range(2))
    assert [d.words for d in one.done] == [d.words for d in other.done] and len(one.done) == 2
    assert first == second and one.left == ()


def test_he_leaves_alone_what_nobody_needs_what_carries_something_and_what_is_under_the_hand():
    cell = laid(2)
    base = cell.simulation.object_pose("violet_cup")
    height = cell.simulation.objects["violet_cup"].size[2] + cell.simulation.objects["blue_cup"].size[2] / 2
    put(cell.simulation, "blue_cup", replace(base, position=(*base.position[:2], height + 0.001)))
    for _ in range(60):
        cell.tick()
    adversary, before, after = disturb(cell, TableDisturbance.TAKE, wanted=("violet_cup", "blue_cup"))
    assert adversary.left == (TableDisturbance.TAKE,) and moved(before, after) == {}
    tool = cell.simulation.tool.position
    spot = cell.simulation.object_pose("green_cup")
    put(cell.simulation, "green_cup", replace(spot, position=(tool[0], tool[1], spot.position[2])))
    adversary, _, _ = disturb(cell, TableDisturbance.TAKE, wanted=("green_cup",))
    assert adversary.done == []
