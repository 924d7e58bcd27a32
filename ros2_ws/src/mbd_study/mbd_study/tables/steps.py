"""The demonstrated steps of a session, a row each."""

from __future__ import annotations

from dataclasses import dataclass

from mbd_bag.session.recorded_session import RecordedSession


@dataclass(frozen=True)
class StepRow:
    """One step of the last task of a session.

    Lengths are in m in the robot base frame, times in s from when the source scene was seen.
    """

    session: str
    step: int
    kind: str
    primary_object: str
    distance_m: float
    runner_up: str
    runner_up_distance_m: float
    start_s: float
    end_s: float
    tool_x_m: float
    tool_y_m: float
    tool_z_m: float


def step_rows(session: RecordedSession) -> tuple[StepRow, ...]:
    """The steps of a session's last task; none where it has no task."""
    if not session.tasks:
        return ()
    task = session.tasks[-1].value
    begin = task.source.stamp
    return tuple(
        StepRow(
            session=session.name,
            step=s.index,
            kind=s.kind.name.lower(),
            primary_object=s.primary_object,
            distance_m=s.distance,
            runner_up=s.runner_up,
            runner_up_distance_m=s.runner_up_distance,
            start_s=s.start - begin,
            end_s=s.end - begin,
            tool_x_m=s.tool_position[0],
            tool_y_m=s.tool_position[1],
            tool_z_m=s.tool_position[2],
        )
        for s in task.steps
    )
