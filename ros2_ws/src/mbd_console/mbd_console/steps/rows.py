"""The demonstrated steps as the page shows them: a sentence, its moments, what is in doubt and what can be changed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.session import Phase
from mbd_model.task import Task, TaskStep
from mbd_model.task_words import Carry, carries

from mbd_console.state import ConsoleState
from mbd_console.words.texts import ENGLISH, PageTexts
from mbd_console.words.things import ThingName, operator_names

CORRECTED_IN = (Phase.DEMONSTRATE, Phase.TUCK_AND_CLEAR, Phase.OBSERVE_TARGET, Phase.ASSIST)
RECORDED_IN = (Phase.DEMONSTRATE, Phase.TUCK_AND_CLEAR)
DOUBTFUL = 0.01  # less is not worth a word


@dataclass(frozen=True)
class StepMoment:
    """When a step ended.

    Attributes:
        caption: of the picture of it: "picked after 2.0 s".
        at: [s].
    """

    caption: str
    at: float


@dataclass(frozen=True)
class ObjectChoice:
    """The objects that a step may be about.

    Attributes:
        step: 0-based.
        label: of the choice.
        present: id of the object that it is about now.
        options: (id, name with its article) of every object of the scene.
        doubted: those of the two, either of which it may be about; () when there is no doubt.
        doubt: probability that the second of them was meant.
    """

    step: int
    label: str
    present: str
    options: tuple[tuple[str, str], ...]
    doubted: tuple[tuple[str, str], ...] = ()
    doubt: float = 0.0

    def change(self, object_id: str) -> StepCorrection:
        """The correction to that object."""
        return StepCorrection(CorrectionKind.CHANGE_OBJECT, self.step, object_id=object_id)


@dataclass(frozen=True)
class CarryRow:
    """One pick and place.

    Attributes:
        sentence: "Pick the red bowl, put it onto the plate."
        moments: of its steps, in order.
        choices: the object of each of its steps.
        earlier, later, join, delete, again: what can be asked for; None where it makes no sense.
        split: from when to when [s] it can be split, at its PLACE; None where it cannot.
        place: 0-based number of its PLACE, -1 when it has none.
    """

    sentence: str
    moments: tuple[StepMoment, ...]
    choices: tuple[ObjectChoice, ...]
    earlier: StepCorrection | None
    later: StepCorrection | None
    join: StepCorrection | None
    delete: StepCorrection
    again: StepCorrection
    split: tuple[float, float] | None
    place: int

    def split_at(self, at: float) -> StepCorrection:
        """The correction that puts the object down on the way, at that time [s]."""
        return StepCorrection(CorrectionKind.SPLIT, self.place, at=at)


def rows(task: Task, texts: PageTexts = ENGLISH) -> tuple[CarryRow, ...]:
    """What the page shows of a task, in order."""
    found, names = carries(task.steps), operator_names(task.source, texts)
    return tuple(_row(task, found, k, names, texts) for k in range(len(found)))


def carry_sentence(carry: Carry, names: Mapping[str, ThingName], texts: PageTexts) -> str:
    """One pick and place: "Pick the red bowl, put it onto the plate."; ``names``: of the source objects, by id."""
    things = {step: names[step.primary_object].accusative for step in carry.steps}
    if carry.place is None:
        said = texts("carry_held", thing=things[carry.steps[0]])
    elif carry.pick is None:
        said = texts("carry_blind", receiver=things[carry.place])
    elif carry.place.primary_object == carry.pick.primary_object:
        said = texts("carry_down", thing=things[carry.pick])
    else:
        said = texts("carry_onto", thing=things[carry.pick], receiver=things[carry.place])
    return said[:1].upper() + said[1:]


def corrected_now(state: ConsoleState, texts: PageTexts = ENGLISH) -> str:
    """Why no step can be corrected now; "" when it can."""
    session = state.session
    if session is None:
        return texts("closed_no_state")
    if state.recording:
        return texts("closed_recording")
    if session.paused:
        return texts("closed_paused")
    return "" if session.phase in CORRECTED_IN else texts("closed_phase")


def recorded_again_now(state: ConsoleState) -> bool:
    """Whether steps can be shown again: the source objects are still on the table."""
    return state.phase in RECORDED_IN


def _row(
    task: Task, all_of_them: tuple[Carry, ...], k: int, names: Mapping[str, ThingName], texts: PageTexts
) -> CarryRow:
    carry = all_of_them[k]
    step, pick, place = carry.first, carry.pick, carry.place
    after = all_of_them[k + 2].first if k + 2 < len(all_of_them) else len(task.steps)
    last = k + 1 == len(all_of_them)
    following = None if last else all_of_them[k + 1].pick
    goes_on = place is not None and pick is not None and following is not None
    return CarryRow(
        sentence=carry_sentence(carry, names, texts),
        moments=tuple(_moment(s, task.steps[0].start, texts) for s in carry.steps),
        choices=tuple(_choice(s, names, texts) for s in carry.steps),
        earlier=None if not k else StepCorrection(CorrectionKind.MOVE, step, to=all_of_them[k - 1].first),
        later=None if last else StepCorrection(CorrectionKind.MOVE, step, to=after),
        join=StepCorrection(CorrectionKind.JOIN, carry.last)
        if goes_on and pick is not None and following is not None and following.primary_object == pick.primary_object
        else None,
        delete=StepCorrection(CorrectionKind.DELETE, step),
        again=StepCorrection(CorrectionKind.RERECORD, step),
        split=(pick.end, place.end) if pick is not None and place is not None and pick.end < place.end else None,
        place=carry.last if place is not None else -1,
    )


def _moment(step: TaskStep, began: float, texts: PageTexts) -> StepMoment:
    """When a step ended, in words, counted from when the first one began [s] where that makes sense."""
    seconds = step.end - began
    after = 0.0 <= seconds < 1e5
    when = texts("moment_after" if after else "moment_at", seconds=f"{seconds if after else step.end:.1f}")
    return StepMoment(texts(f"moment_{step.kind.name}", when=when), step.end)


def _choice(step: TaskStep, names: Mapping[str, ThingName], texts: PageTexts) -> ObjectChoice:
    in_doubt = step.doubt >= DOUBTFUL and step.runner_up in names
    return ObjectChoice(
        step=step.index,
        label=texts(f"choice_{step.kind.name}"),
        present=step.primary_object,
        options=tuple((i, name.nominative) for i, name in names.items()),
        doubted=tuple((i, names[i].nominative) for i in (step.primary_object, step.runner_up)) if in_doubt else (),
        doubt=step.doubt if in_doubt else 0.0,
    )
