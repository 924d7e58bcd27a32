"""What a look at the table makes of the work: where everything is now, and what has to be done again or asked about."""

from __future__ import annotations

import math
from dataclasses import replace

from mbd_demonstration.tracked_objects import TrackedObjects
from mbd_model.execution_progress import Failure, Status
from mbd_model.objects import Scene

from mbd_execution.boxes import bottom, sides, top
from mbd_execution.looking.changes import APART, Looked, TableChange, TableDifference, look
from mbd_execution.looking.expected import stood_up
from mbd_execution.looking.in_hand import another_in_hand
from mbd_execution.placing import INTO, Held
from mbd_execution.plan import Transfer
from mbd_execution.work.failures import HANDLING, listed, trouble
from mbd_execution.work.state import Done, Work, with_status

SHARE = 0.35  # of half the receiver's narrower side, by which what was put onto it may be off
NEAR = 0.02  # [m] by which what was put somewhere may be off at least
SUNK = 0.02  # [m] by which its top may be lower than it was


def looked_at(work: Work, scene: Scene) -> Work:
    """The work after a look.

    Args:
        work: before it.
        scene: what was seen, with the arm aside.
    """
    carried = work.carried
    in_hand = carried.held.box.object_id if carried else ""
    # Until a look shows it upright, what fell over lies: not in the next look alone, in which it is where it lay.
    lying = work.fallen - {in_hand}
    before = stood_up(work.table, lying, work.plan.table)
    taken = another_in_hand(before, scene, in_hand, lying) if in_hand else ""
    seen = look(before, scene, taken or in_hand, lying)
    fallen = frozenset(d.object_id for d in seen.of(TableChange.FALLEN))
    work = replace(work, table=seen.table, gone=seen.gone, fallen=fallen, looked=True, noticed=_words(work, seen))
    if carried is not None:
        work = _in_hand_checked(work, seen, taken)
    for done in work.done:
        if work.failure is None:
            work = _place_checked(work, done, before, seen)
    for difference in seen.differences:
        if work.failure is None:
            work = _choice_asked(work, difference)
        if work.failure is None:
            work = _newcomer_asked(work, difference)
    if work.failure is None and work.carried is None and work.next_transfer is not None:
        work = _needed_checked(work, work.next_transfer)
    elif work.failure is None and work.carried is not None:
        work = _receiver_checked(work, work.carried.transfer)
    return work


def _words(work: Work, seen: Looked) -> str:
    """What changed and needs no question, in words."""
    parts = []
    for d in seen.differences:
        if d.change is TableChange.MOVED:
            parts.append(f"{d.object_id} was moved")
        elif d.change is TableChange.NEW:
            parts.append(f"{d.object_id} is new{f', it looks like {d.other}' if d.other else ''}")
        elif d.change is TableChange.SWAPPED:
            parts.append(f"{d.object_id} is where {d.other} was")
        elif d.object_id not in work.accepted:
            parts.append(f"{d.object_id} is {d.change}")
    return "; ".join(parts)


def _in_hand_checked(work: Work, seen: Looked, taken: str) -> Work:
    """Whether the right object left the table; ``taken``: id of another one that did."""
    carried = work.carried
    if carried is None:
        return work
    box = carried.held.box
    alike = [d.object_id for d in seen.of(TableChange.NEW) if d.other == box.object_id]
    still = [n for n in alike if math.dist(seen.table[n].centroid[:2], box.centroid[:2]) < APART]
    if not taken and not still:
        return work
    step = carried.transfer.shown.pick
    work, times = work.tried(box.object_id, Failure.WRONG_OBJECT)
    statuses = with_status(work.statuses, Status.PLANNED, step)
    if taken and times < HANDLING[Failure.WRONG_OBJECT].limit:
        other = work.table[taken]
        if math.dist(work.table[box.object_id].centroid[:2], box.centroid[:2]) > APART:
            # Somebody had put the other one in its place: there the hand took it, and there it goes back to.
            other = replace(other, centroid=(*box.centroid[:2], other.centroid[2]))
        objects = tuple(other if o.object_id == taken else o for o in work.table.objects)
        held = Held(other, carried.held.grasp)
        back = replace(carried, held=held, transfer=replace(carried.transfer, held=taken), origin=other)
        return replace(work, table=replace(work.table, objects=objects), carried=back, statuses=statuses)
    if not taken:
        # What looks like it stands where it stood, and nobody knows what is in the hand.
        stands = replace(seen.table[still[0]], object_id=box.object_id)
        others = [o for o in work.table.objects if o.object_id != still[0]]
        objects = tuple(stands if o.object_id == box.object_id else o for o in others)
        work = replace(work, table=replace(work.table, objects=objects))
    what = f"I hold something, but {box.object_id} still stands on the table"
    return replace(work, failure=trouble(Failure.WRONG_OBJECT, step, what, box.object_id), statuses=statuses)


def _place_checked(work: Work, done: Done, before: TrackedObjects, seen: Looked) -> Work:
    """Whether what was put somewhere still stands there; the last one put is done again by the robot itself."""
    held, receiver, shown = done.transfer.held, done.transfer.receiver, done.transfer.shown
    if not _is_to_be_put_right(work, done, before, seen):
        return work
    work, times = work.tried(held, Failure.NOT_IN_PLACE)
    lies = held in work.fallen
    last = done is work.done[-1] and work.carried is None
    if last and not lies and held not in work.gone and times < HANDLING[Failure.NOT_IN_PLACE].limit:
        statuses = with_status(work.statuses, Status.PLANNED, shown.pick, shown.place)
        return replace(work, done=work.done[:-1], statuses=statuses)
    state = "has fallen over" if lies else "is not there any more" if held in work.gone else "does not stand"
    where = f"onto {receiver}" if receiver else "on the table"
    what = f"I put {held} {where}, and it {state}{'' if lies or held in work.gone else ' there now'}"
    # A pile falls as one: it is one thing to ask for.
    later = work.done[work.done.index(done) + 1 :]
    also = tuple(d.transfer.held for d in later if _is_to_be_put_right(work, d, before, seen))
    if also:
        what += f"; {listed(also)} likewise"
    return replace(work, failure=trouble(Failure.NOT_IN_PLACE, shown.place, what, held, done=True, also=also))


def _is_to_be_put_right(work: Work, done: Done, before: TrackedObjects, seen: Looked) -> bool:
    """Whether something that was set down is astray, and nobody has said to leave it so."""
    return done.transfer.held not in work.accepted and _astray(work, done, before, seen)


def _astray(work: Work, done: Done, before: TrackedObjects, seen: Looked) -> bool:
    """Whether an object that was set down is not where it was set down, on the receiver where that is now."""
    held, receiver = done.transfer.held, done.transfer.receiver
    if held in work.gone or seen.of(TableChange.FALLEN, held):
        return True
    now = work.table[held]
    if receiver is None or receiver in work.gone:
        return receiver is None and bool(seen.of(TableChange.MOVED, held))
    if (held, receiver) not in work.table.rests_on:
        return True
    carrier = work.table[receiver]
    allowed = max(NEAR, SHARE * sides(carrier)[1] / 2)
    was, under = before[held].centroid, before[receiver].centroid
    off = (now.centroid[i] - carrier.centroid[i] - was[i] + under[i] for i in range(2))
    # What was put into something may come to rest deeper in it than it was let go.
    inside = bottom(before[held]) < top(before[receiver]) - INTO
    return math.hypot(*off) > allowed or (not inside and top(before[held]) - top(now) > SUNK)


def _choice_asked(work: Work, difference: TableDifference) -> Work:
    """Ask which of two objects is which, when one of them is still needed."""
    if difference.change not in (TableChange.SWAPPED, TableChange.UNSURE) or difference.object_id in work.accepted:
        return work
    if difference.change is TableChange.SWAPPED and difference.otherwise is None:
        return work  # they do not look alike: it is clear which is which
    name, other = difference.object_id, difference.other
    step = next((s for t in _open(work) for s in _steps_of(t, name)), None)
    if step is None:
        return work
    x, y, _ = work.table[name].centroid
    there = f"the one at ({x:.2f}, {y:.2f}) m"
    if difference.change is TableChange.SWAPPED:
        what = f"I think {name} and {other} have changed places, and take {there} for {name}"
    elif other:
        what = f"I am not sure which object is {name} and which is {other}, and take {there} for {name}"
    else:
        what = f"I am not sure whether {there} is {name}, and take it for that"
    return replace(work, failure=trouble(Failure.WHICH_ONE, step, what, name, difference.otherwise))


def _newcomer_asked(work: Work, difference: TableDifference) -> Work:
    """Ask about a new object that could be taken for one that is still needed."""
    name, new = difference.other, difference.object_id
    there = {o.object_id for o in work.table.objects} - work.gone
    if difference.change is not TableChange.NEW or not {name, new} <= there or name in work.accepted:
        return work
    if work.carried is not None and work.carried.held.box.object_id == name:
        return work
    step = next((s for t in _open(work) for s in _steps_of(t, name)), None)
    if step is None:
        return work
    old, like = work.table[name], work.table[new]
    places = {name: like.centroid, new: old.centroid}
    exchanged = replace(
        work.table,
        objects=tuple(
            replace(o, centroid=(*places[o.object_id][:2], o.centroid[2])) if o.object_id in places else o
            for o in work.table.objects
        ),
    )
    (x, y, _), (u, v, _) = old.centroid, like.centroid
    new_one = f"something new at ({u:.2f}, {v:.2f}) m looks like {name}"
    what = f"{new_one}, and I still take the one at ({x:.2f}, {y:.2f}) m for {name}"
    return replace(work, failure=trouble(Failure.WHICH_ONE, step, what, name, exchanged))


def _needed_checked(work: Work, transfer: Transfer) -> Work:
    """Whether what the next transfer needs is there, and stands."""
    work = _usable(work, transfer.held, transfer.shown.pick)
    return work if work.failure is not None else _receiver_checked(work, transfer)


def _receiver_checked(work: Work, transfer: Transfer) -> Work:
    return _usable(work, transfer.receiver, transfer.shown.place) if transfer.receiver else work


def _usable(work: Work, name: str, step: int) -> Work:
    if name in work.gone:
        work, times = work.tried(name, Failure.NOT_THERE)
        if times < HANDLING[Failure.NOT_THERE].limit:
            return replace(work, looked=False)  # somebody's arm may have hidden it
        what = f"I do not see {name} any more"
        return _failed_step(work, Failure.NOT_THERE, step, what, name)
    if name in work.fallen and name not in work.accepted:
        return _failed_step(work, Failure.FALLEN_OVER, step, f"{name} has fallen over", name)
    return work


def _failed_step(work: Work, failure: Failure, step: int, what: str, name: str) -> Work:
    statuses = with_status(work.statuses, Status.FAILED, step)
    return replace(work, failure=trouble(failure, step, what, name), statuses=statuses)


def _open(work: Work) -> tuple[Transfer, ...]:
    """The transfers still to be done, the one of what is in the hand included."""
    return work.wanted[len(work.done) :]


def _steps_of(transfer: Transfer, name: str) -> list[int]:
    """The steps of a transfer that use an object."""
    uses = [transfer.shown.pick] if transfer.held == name else []
    return uses + ([transfer.shown.place] if transfer.receiver == name else [])
