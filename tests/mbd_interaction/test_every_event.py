"""Every event in every phase is taken or refused with a reason, and leaves a consistent state."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_interaction.dialogue import Dialogue, Outcome
from mbd_interaction.effects import PublishAssists
from mbd_interaction.events import INTERNAL, Event, Signal
from mbd_interaction.synthetic import SECOND, random_event, random_walk
from mbd_interaction.transitions import TABLE, transition
from mbd_model.session import Phase


def check(before: Dialogue, event: Event, outcome: Outcome) -> None:
    after = outcome.dialogue
    assert after.phase is before.phase or after.phase in TABLE[before.phase, event.signal].leads_to
    if outcome.reply and not outcome.reply.accepted and event.signal not in INTERNAL:
        assert after == before and outcome.effects == ()
    if event.signal in INTERNAL and before.pending == after.pending:
        assert outcome.reply is None
    if event.signal not in INTERNAL:
        assert (outcome.reply is None) == (after.pending is not None and before.pending is None)
    if outcome.reply:
        assert outcome.reply.reason
    assert after.num_events == before.num_events + bool(outcome.reply and outcome.reply.accepted)
    published = [e for e in outcome.effects if isinstance(e, PublishAssists)]
    assert (after.assists != before.assists) <= bool(published)
    if published:
        assert published[-1].assists == after.assists and published[-1].stamp == after.assists_stamp
        assert after.assists_stamp > before.assists_stamp
    sources = [a.source_id for a in after.assists]
    assert len(set(sources)) == len(sources)
    if after.step_index >= 0 and after.task:
        assert after.step_index < len(after.steps)
    if after.phase not in (Phase.TUCK_AND_CLEAR, Phase.ASSIST, Phase.EXECUTE):
        assert after.step_index == -1
    if after.phase is Phase.TUCK_AND_CLEAR:
        assert (after.step_index >= 0) == (after.question is not None)


def wander(rng: np.random.Generator, n_events: int, start: Dialogue) -> list[Dialogue]:
    """A dialogue fed with random events, of which the requests are often answered as they should be."""
    path = [start]
    for dialogue, event, outcome in random_walk(rng, n_events, start):
        check(dialogue, event, outcome)
        path.append(outcome.dialogue)
    return path


@given(seed=st.integers(0, 2**32))
def test_random_events_leave_a_consistent_state(seed):
    wander(np.random.default_rng(seed), 200, Dialogue("random"))


def test_ten_thousand_random_events_visit_every_phase_and_leave_a_consistent_state():
    path = wander(np.random.default_rng(5), 10_000, Dialogue("random"))
    assert {d.phase for d in path} == set(Phase)


def states_of_every_phase() -> dict[Phase, list[Dialogue]]:
    found: dict[Phase, list[Dialogue]] = {phase: [] for phase in Phase}
    for dialogue in wander(np.random.default_rng(5), 4000, Dialogue("random")):
        if len(found[dialogue.phase]) < 30:
            found[dialogue.phase].append(dialogue)
    return found


STATES = states_of_every_phase()


@pytest.mark.parametrize(("phase", "signal"), list(itertools.product(Phase, Signal)), ids=str)
def test_the_full_table(phase: Phase, signal: Signal):
    """Any event of that kind, in thirty different states of that phase."""
    rng = np.random.default_rng(3)
    for dialogue in STATES[phase]:
        event = random_event(rng, dialogue, 10**6 * SECOND, 5, signal)
        check(dialogue, event, transition(dialogue, event))
