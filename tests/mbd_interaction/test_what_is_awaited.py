"""What the dialogue states it awaits is what lets it go on, and no sentence decides anything."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_interaction import events
from mbd_interaction.config import DialogueConfig
from mbd_interaction.dialogue import Dialogue
from mbd_interaction.events import Event, Signal
from mbd_interaction.restore import restored
from mbd_interaction.synthetic import SECOND, SIGNAL_OF_AWAITED, awaited_event, random_walk, stacking_task
from mbd_interaction.transitions import transition
from mbd_model.estimate import QuestionKind
from mbd_model.session import Awaited, Phase
from rewording import REWORDINGS, reworded, without_sentences

START = Dialogue("random")
EXECUTING = Dialogue("random", config=DialogueConfig(execute=True))
NAMING = Dialogue("random", config=DialogueConfig(question_kinds=tuple(QuestionKind)[:3]))
# Questions that name objects take an object, besides, in whatever way it is given.
NAMED = (Awaited.CONFIRMATION, Awaited.YES_OR_NO, Awaited.HELP, Awaited.ONE_OF_TWO)
LATER = 10**6 * SECOND


def dialogues(seed: int, n_events: int, start: Dialogue) -> list[Dialogue]:
    walk = random_walk(np.random.default_rng(seed), n_events, start, led=0.3)
    return [start, *(outcome.dialogue for _, _, outcome in walk)]


@given(seed=st.integers(0, 2**32), start=st.sampled_from([START, EXECUTING, NAMING]))
def test_what_is_awaited_is_never_refused_and_leads_on(seed: int, start: Dialogue):
    for dialogue in dialogues(seed, 60, start):
        event = awaited_event(dialogue, LATER, 5, confidence=0.3)
        if event is not None:
            outcome = transition(dialogue, event)
            assert outcome.reply is None or outcome.reply.accepted, (dialogue.awaiting, outcome.reply)
            after = outcome.dialogue
            assert (after.awaiting, after.step_index, after.phase) != (
                dialogue.awaiting,
                dialogue.step_index,
                dialogue.phase,
            )


@given(seed=st.integers(0, 2**32), start=st.sampled_from([START, NAMING]))
def test_an_answer_of_the_other_kind_than_awaited_is_refused(seed: int, start: Dialogue):
    for dialogue in dialogues(seed, 100, start):
        for awaiting in (Awaited.HANDED, Awaited.POINTED):
            if dialogue.phase is Phase.ASSIST and dialogue.awaiting not in (awaiting, *NAMED):
                answer = events.Answered(SIGNAL_OF_AWAITED[awaiting], LATER, "wizard/x", "t1")
                reply = transition(dialogue, answer).reply
                assert reply is not None and not reply.accepted


@given(seed=st.integers(0, 2**32), start=st.sampled_from([START, NAMING]))
def test_yes_and_no_are_taken_when_they_are_asked_for_and_never_else(seed: int, start: Dialogue):
    for dialogue in dialogues(seed, 100, start):
        for signal, taken in ((Signal.YES, NAMED[:3]), (Signal.NO, NAMED)):
            reply = transition(dialogue, Event(signal, LATER, "wizard/answer")).reply
            if dialogue.phase is Phase.EXECUTE and signal is Signal.NO:
                continue  # "not that one": taken while the robot is at a step
            assert reply is not None and reply.accepted == (dialogue.awaiting in taken), reply


def test_everything_that_can_be_awaited_is_at_some_time():
    seen = {d.awaiting for start in (START, EXECUTING, NAMING) for d in dialogues(1, 2000, start)}
    back = Dialogue("back", Phase.ASSIST)
    seen |= {back.awaiting, replace(back, task=stacking_task(3)).awaiting}  # a node that came back
    assert seen == set(Awaited) - {Awaited.UNKNOWN}


@given(seed=st.integers(0, 2**32))
def test_a_dialogue_that_comes_back_records_as_before_and_awaits_no_answer_that_is_lost(seed: int):
    for dialogue in dialogues(seed, 60, START):
        again = restored(dialogue.state, dialogue.assists_stamp, dialogue.config)
        assert again.recording == dialogue.recording
        assert again.awaiting not in (Awaited.OBSERVATION, Awaited.RECORDING)
        if dialogue.phase is not Phase.ASSIST and dialogue.pending is None:
            assert again.awaiting is dialogue.awaiting


@pytest.mark.parametrize("words", REWORDINGS.values(), ids=REWORDINGS)
@pytest.mark.parametrize("start", [START, EXECUTING, NAMING], ids=["states", "executes", "names objects"])
def test_reworded_events_make_the_same_dialogue_but_for_its_sentences(words, start: Dialogue):
    """Answers of other nodes, progress, warnings and problems come in other words; so did all that came before."""
    changed = 0
    for dialogue, event, outcome in random_walk(np.random.default_rng(4), 700, start, led=0.3):
        other = transition(reworded(dialogue, words), reworded(event, words))
        assert without_sentences(other) == without_sentences(outcome)
        changed += other != outcome
    assert changed > 100
