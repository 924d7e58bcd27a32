"""A session's estimates come out again from its recorded inputs, and a bag that was tampered with is found out."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_bag.errors import BagError
from mbd_bag.ros.session_conversions import session_from_bag, session_to_bag
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_mapping.config import MappingConfig
from mbd_model.assists import Assist
from mbd_model.estimate import Mapping
from mbd_model.objects import Role
from mbd_study.recompute import replay_command as replay
from mbd_study.recompute.reevaluation import reevaluate
from mbd_study.recompute.same_objects import named_as
from mbd_study.synthetic import SyntheticSession, scene, session


def with_estimate(recorded: RecordedSession, index: int, **changes: object) -> RecordedSession:
    """The session with one recorded estimate changed."""
    estimates = list(recorded.estimates)
    estimate, inputs = estimates[index]
    estimates[index] = (replace(estimate, value=replace(estimate.value, **changes)), inputs)
    return replace(recorded, estimates=tuple(estimates))


def replay_of(recorded: RecordedSession, folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Exit code of ``replay`` on a bag of the session."""
    with BagWriter(folder) as bag:
        session_to_bag(recorded, bag)
    monkeypatch.setattr(sys, "argv", ["replay", str(folder), "--check"])
    with pytest.raises(SystemExit) as ended:
        replay.main()
    return int(ended.value.code)


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1), num_assists=st.integers(0, 6))
def test_what_was_recorded_is_computed_again_for_any_session(seed: int, num_assists: int):
    comparisons = reevaluate(session("any", np.random.default_rng(seed), num_assists=num_assists).recorded)
    assert len(comparisons) == num_assists + 1
    assert all(c.agrees for c in comparisons)


def test_the_tool_agrees_with_an_honest_bag(
    made: SyntheticSession, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    assert replay_of(made.recorded, tmp_path / "bag", monkeypatch) == 0
    assert "agrees: 4 of 4 estimates" in capsys.readouterr().out


@pytest.mark.parametrize("field", ["confidence", "ties", "mapping", "winning", "warnings"])
def test_a_tampered_estimate_is_reported_by_field_and_number(
    field: str,
    made: SyntheticSession,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
):
    old = made.recorded.estimates[2][0].value
    new = {
        "confidence": old.confidence + 1e-8,
        "ties": old.ties + 1,
        "mapping": Mapping(old.mapping.pairs[::-1], old.mapping.score),
        "winning": (),
        "warnings": ("nothing of the kind",),
    }
    tampered = with_estimate(made.recorded, 2, **{field: new[field]})
    assert replay_of(tampered, tmp_path / "bag", monkeypatch) == 1
    output = capsys.readouterr().out
    assert "differs: only 3 of 4 estimates agree" in output
    assert f"{field}: recorded" in output


def test_a_difference_below_the_tolerance_is_none(made: SyntheticSession):
    old = made.recorded.estimates[2][0].value
    assert all(c.agrees for c in reevaluate(with_estimate(made.recorded, 2, confidence=old.confidence + 1e-12)))


def test_a_tampered_input_is_found_out_too(made: SyntheticSession):
    first = made.recorded.assists[1]
    lie = replace(first, value=(replace(first.value[0], target_id=made.recorded.target_scenes[0].value.ids[-1]),))
    assert lie != first
    tampered = replace(made.recorded, assists=(made.recorded.assists[0], lie, *made.recorded.assists[2:]))
    assert [c.agrees for c in reevaluate(tampered)] == [True, False, True, True]


def test_an_estimate_repeated_by_a_restarted_node_agrees_too(made: SyntheticSession):
    last, inputs = made.recorded.estimates[-1]
    again = (replace(last, log_time=last.log_time + 1_000_000), inputs)
    assert all(c.agrees for c in reevaluate(replace(made.recorded, estimates=(*made.recorded.estimates, again))))


def test_an_estimate_recorded_before_its_own_input_finds_it(made: SyntheticSession):
    late = tuple(replace(a, log_time=a.log_time + 5_000_000_000) for a in made.recorded.assists)
    assert all(c.agrees for c in reevaluate(replace(made.recorded, assists=late)))


def test_an_estimate_whose_inputs_are_not_in_the_bag_does_not_agree(made: SyntheticSession):
    (comparison, *_) = reevaluate(replace(made.recorded, target_scenes=()))
    assert comparison.computed is None
    assert "target scene" in comparison.differences[0].recorded


def test_the_recorded_parameters_are_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    config = MappingConfig(sigma=0.9, threshold=0.3)
    wide = session("wide", np.random.default_rng(4), config=config).recorded
    assert replay_of(wide, tmp_path / "bag", monkeypatch) == 0
    forgotten = {k: v for k, v in wide.facts.items() if k != "parameter./mapping.sigma"}
    assert not all(c.agrees for c in reevaluate(replace(wide, facts=forgotten)))


def test_parameters_of_another_version_are_an_error(made: SyntheticSession):
    facts = made.recorded.facts | {"parameter./mapping.sigma": "wide"}
    with pytest.raises(BagError, match="sigma"):
        reevaluate(replace(made.recorded, facts=facts))


def test_a_session_without_estimates_has_nothing_to_compare(
    made: SyntheticSession, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    assert replay_of(replace(made.recorded, estimates=()), tmp_path / "bag", monkeypatch) == 2
    assert "no mapping estimate" in capsys.readouterr().err


def test_an_assist_of_an_unknown_object_is_warned_of_again(made: SyntheticSession, tmp_path: Path):
    """Warnings are part of the estimate: a bag in which the node warned replays with the same warning."""
    first = made.recorded.assists[1]
    unknown = replace(first, value=(Assist("s1", "nobody", 0),))
    lied = replace(made.recorded, assists=(made.recorded.assists[0], unknown))
    comparison = reevaluate(lied)[1]
    assert comparison.computed is not None
    assert "nobody" in comparison.computed.warnings[0]
    with BagWriter(tmp_path / "bag") as bag:
        session_to_bag(with_estimate(lied, 1, **vars(comparison.computed)), bag)
    assert reevaluate(session_from_bag(Bag(tmp_path / "bag")))[1].agrees


@given(seed=st.integers(0, 2**32 - 1), shift=st.floats(0.0, 0.01))
def test_objects_seen_in_another_order_keep_their_names(seed: int, shift: float):
    rng = np.random.default_rng(seed)
    recorded = scene(Role.SOURCE, 1.0, rng)
    # Perception numbers what it sees by its order: the same objects, a little moved, in another one.
    order = rng.permutation(len(recorded.objects))
    names = {recorded.objects[int(k)].object_id: f"s{n}" for n, k in enumerate(order, start=1)}
    seen = tuple(
        replace(
            o,
            object_id=names[o.object_id],
            centroid=(o.centroid[0] + shift, *o.centroid[1:]),
            relations=tuple((kind, names[other]) for kind, other in o.relations),
        )
        for o in (recorded.objects[int(k)] for k in order)
    )
    again = named_as(recorded, replace(recorded, objects=seen))
    assert again.ids == recorded.ids
    assert [o.relations for o in again.objects] == [o.relations for o in recorded.objects]
    assert [o.hue for o in again.objects] == [o.hue for o in recorded.objects]


def test_what_is_not_the_same_objects_is_left_as_it_was_seen():
    recorded = scene(Role.SOURCE, 1.0, np.random.default_rng(0))
    fewer = replace(recorded, objects=recorded.objects[1:])
    far = replace(recorded.objects[0], centroid=(9.0, 9.0, 0.0))
    elsewhere = replace(recorded, objects=(*recorded.objects[1:], far))
    assert named_as(recorded, fewer) is fewer
    assert named_as(recorded, elsewhere) is elsewhere
