"""Between assists and denials and mbd_msgs/Assists."""

from __future__ import annotations

from mbd_msgs import msg as m

from mbd_model.assists import Assist, AssistKind, Denial
from mbd_model.ros.conversions.times import header, time_from_msg, time_to_msg


def assist_to_msg(value: Assist) -> m.Assist:
    """One assist."""
    return m.Assist(
        source_id=value.source_id,
        target_id=value.target_id,
        step_index=value.step_index,
        kind=int(value.kind),
        stamp=time_to_msg(value.stamp),
        confirmed=value.confirmed,
    )


def assist_from_msg(msg: m.Assist) -> Assist:
    """One assist."""
    return Assist(
        source_id=msg.source_id,
        target_id=msg.target_id,
        step_index=int(msg.step_index),
        kind=AssistKind(msg.kind),
        stamp=time_from_msg(msg.stamp),
        confirmed=bool(msg.confirmed),
    )


def denial_to_msg(value: Denial) -> m.Denial:
    """One "no"."""
    return m.Denial(
        source_id=value.source_id,
        target_id=value.target_id,
        step_index=value.step_index,
        stamp=time_to_msg(value.stamp),
    )


def denial_from_msg(msg: m.Denial) -> Denial:
    """One "no"."""
    return Denial(
        source_id=msg.source_id,
        target_id=msg.target_id,
        step_index=int(msg.step_index),
        stamp=time_from_msg(msg.stamp),
    )


def assists_to_msg(
    values: tuple[Assist, ...], stamp: float, session: str, denials: tuple[Denial, ...] = ()
) -> m.Assists:
    """The complete list of assists, and of denials, in force, published at ``stamp`` [s]."""
    return m.Assists(
        header=header(stamp),
        session=session,
        assists=[assist_to_msg(a) for a in values],
        denials=[denial_to_msg(d) for d in denials],
    )


def assists_from_msg(msg: m.Assists) -> tuple[Assist, ...]:
    """The complete list of assists in force, oldest first."""
    return tuple(assist_from_msg(a) for a in msg.assists)


def denials_from_msg(msg: m.Assists) -> tuple[Denial, ...]:
    """Every denial in force, oldest first."""
    return tuple(denial_from_msg(d) for d in msg.denials)
