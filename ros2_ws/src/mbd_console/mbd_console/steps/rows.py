"""The demonstrated steps as the page shows them: a sentence, its moments, what is in doubt and what can be changed."""

from __future__ import annotations

from dataclasses import dataclass

from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.session import Phase
from mbd_model.task import StepKind, Task, TaskStep
from mbd_model.task_words import Carry, carries, names_in, sentence

from mbd_console.state import ConsoleState

CORRECTED_IN = (Phase.DEMONSTRATE, Phase.TUCK_AND_CLEAR, Phase.OBSERVE_TARGET, Phase.ASSIST)
RECORDED_IN = (Phase.DEMONSTRATE, Phase.TUCK_AND_CLEAR)
DOUBTFUL = 0.01  # less is not worth a word


@dataclass(frozen=True)
class StepMoment:
    """When a step ended, and what to call that: "picked" or "let go".

    Attributes:
        caption: for the picture.
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
        options: (id, name) of every object of the scene.
        doubted: (id, name) of the two, either of which it may be about; () when there is no doubt.
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


def rows(task: Task) -> tuple[CarryRow, ...]:
    """What the page shows of a task, in order."""
    found = carries(task.steps)
    return tuple(_row(task, found, k) for k in range(len(found)))


def corrected_now(state: ConsoleState) -> str:
    """Why no step can be corrected now; "" when it can."""
    session = state.session
    if session is None:
        return "no state of the dialogue was received yet"
    if state.recording:
        return "a demonstration is being recorded: end it first"
    if session.paused:
        return "the session is paused"
    return "" if session.phase in CORRECTED_IN else "the robot no longer asks about the task"


def recorded_again_now(state: ConsoleState) -> bool:
    """Whether steps can be shown again: the source objects are still on the table."""
    return state.phase in RECORDED_IN


def _row(task: Task, all_of_them: tuple[Carry, ...], k: int) -> CarryRow:
    carry = all_of_them[k]
    step, pick, place = carry.first, carry.pick, carry.place
    after = all_of_them[k + 2].first if k + 2 < len(all_of_them) else len(task.steps)
    last = k + 1 == len(all_of_them)
    following = None if last else all_of_them[k + 1].pick
    goes_on = place is not None and pick is not None and following is not None
    return CarryRow(
        sentence=sentence(task, carry),
        moments=tuple(StepMoment("picked" if s.kind is StepKind.PICK else "let go", s.end) for s in carry.steps),
        choices=tuple(_choice(task, s) for s in carry.steps),
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


def _choice(task: Task, step: TaskStep) -> ObjectChoice:
    names = names_in(task.source)
    picked = step.kind is StepKind.PICK
    in_doubt = step.doubt >= DOUBTFUL and step.runner_up in names
    return ObjectChoice(
        step=step.index,
        label="Another object was picked" if picked else "It was put onto another",
        present=step.primary_object,
        options=tuple(names.items()),
        doubted=tuple((i, names[i]) for i in (step.primary_object, step.runner_up)) if in_doubt else (),
        doubt=step.doubt if in_doubt else 0.0,
    )
