"""Between corrections of a task and mbd_msgs/WizardRevision and ReviseTask's request, which have the same fields."""

from __future__ import annotations

from mbd_msgs import msg as m
from mbd_msgs.srv import ReviseTask

from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.errors import MbdError
from mbd_model.ros.conversions.times import header, time_from_msg, time_to_msg


def correction_from_msg(msg: m.WizardRevision | ReviseTask.Request) -> StepCorrection:
    """The correction that is asked for; raises MbdError for a change there is not."""
    try:
        kind = CorrectionKind(msg.change)
    except ValueError:
        known = ", ".join(f"{k.name} ({k.value})" for k in CorrectionKind)
        raise MbdError(f"change {msg.change} is unknown; expected {known}") from None
    return StepCorrection(kind, int(msg.step), int(msg.to), msg.object, time_from_msg(msg.at))


def correction_to_msg(value: StepCorrection, stamp: float) -> m.WizardRevision:
    """The correction as the operator asks for it at ``stamp`` [s]."""
    return m.WizardRevision(
        header=header(stamp),
        change=int(value.kind),
        step=value.step,
        to=value.to,
        object=value.object_id,
        at=time_to_msg(value.at),
    )


def correction_to_request(value: StepCorrection) -> ReviseTask.Request:
    """The correction as the demonstration node is asked for it."""
    return ReviseTask.Request(
        change=int(value.kind), step=value.step, to=value.to, object=value.object_id, at=time_to_msg(value.at)
    )
