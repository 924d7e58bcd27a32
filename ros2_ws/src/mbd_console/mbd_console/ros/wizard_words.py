"""What the operator and the participant press, as messages on the topics of the session."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Point
from mbd_model.errors import MbdError
from mbd_model.ros import conversions
from mbd_model.ros.qos import EVENTS
from mbd_model.session import Phase
from mbd_msgs import msg as m
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Header

from mbd_console.actions import Action
from mbd_console.requests import (
    AnswerQuestion,
    BeginSession,
    CorrectStep,
    Overwrite,
    PointAtPlace,
    Press,
    PublishedRequest,
    SubmitForm,
    WriteNote,
)
from mbd_console.state import ConsoleState

PRESSES: dict[Action, tuple[type, str, int]] = {
    Action.OPEN: (m.WizardGripper, "wizard/gripper", m.WizardGripper.OPEN),
    Action.CLOSE: (m.WizardGripper, "wizard/gripper", m.WizardGripper.CLOSE),
    Action.START: (m.WizardDemonstration, "wizard/demonstration", m.WizardDemonstration.START),
    Action.STOP: (m.WizardDemonstration, "wizard/demonstration", m.WizardDemonstration.STOP),
    Action.NEXT: (m.WizardCommand, "wizard/command", m.WizardCommand.NEXT_PHASE),
    Action.YES: (m.WizardAnswer, "wizard/answer", m.WizardAnswer.YES),
    Action.NO: (m.WizardAnswer, "wizard/answer", m.WizardAnswer.NO),
    Action.UNDO: (m.WizardCommand, "wizard/command", m.WizardCommand.UNDO),
    Action.SKIP: (m.WizardCommand, "wizard/command", m.WizardCommand.SKIP),
    Action.PAUSE: (m.WizardCommand, "wizard/command", m.WizardCommand.PAUSE),
    Action.BACK: (m.WizardCommand, "wizard/command", m.WizardCommand.BACK),
    Action.REDO: (m.WizardCommand, "wizard/command", m.WizardCommand.REDO),
    Action.ABORT: (m.WizardCommand, "wizard/command", m.WizardCommand.ABORT),
}
WIZARD: dict[str, type] = {
    "wizard/gripper": m.WizardGripper,
    "wizard/demonstration": m.WizardDemonstration,
    "wizard/command": m.WizardCommand,
    "wizard/answer": m.WizardAnswer,
    "wizard/handed": m.WizardHanded,
    "wizard/pointed": m.WizardPointed,
    "wizard/overwrite": m.WizardOverwrite,
    "wizard/revision": m.WizardRevision,
    "wizard/note": m.WizardNote,
}


class WizardWords:
    """Publishers of everything that a page can ask for but the stop. rclpy publishes from any thread.

    Args:
        node: that publishes.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._out: dict[str, Publisher[Any]] = {
            topic: node.create_publisher(kind, topic, EVENTS) for topic, kind in WIZARD.items()
        }
        self._filled = node.create_publisher(m.FilledForm, "study/form", EVENTS)
        self._begin = node.create_publisher(m.NextSession, "session/begin", EVENTS)

    def publish(self, request: PublishedRequest, state: ConsoleState) -> None:
        """Publish a request; its reply comes on interaction/replies.

        Args:
            request: of a page.
            state: what the pages show: a press of PAUSE means RESUME where everything stands, and a form names the
                session in which it was filled in.

        Raises:
            MbdError: nobody would receive it, as in the first moment after a start.
        """
        header = Header(stamp=self._node.get_clock().now().to_msg())
        if isinstance(request, Press):
            self._press(request.action, state, header)
        elif isinstance(request, AnswerQuestion) and request.pointed:
            self._listened("wizard/pointed").publish(m.WizardPointed(header=header, object_id=request.object_id))
        elif isinstance(request, AnswerQuestion):
            self._listened("wizard/handed").publish(m.WizardHanded(header=header, object_id=request.object_id))
        elif isinstance(request, PointAtPlace):
            place = Point(x=request.place[0], y=request.place[1], z=request.place[2])
            self._listened("wizard/pointed").publish(m.WizardPointed(header=header, place=place))
        elif isinstance(request, Overwrite):
            self._listened("wizard/overwrite").publish(
                m.WizardOverwrite(header=header, step_index=request.step_index, object_id=request.object_id)
            )
        elif isinstance(request, CorrectStep):
            revision = conversions.correction_to_msg(request.correction, 0.0)
            revision.header = header
            self._listened("wizard/revision").publish(revision)
        elif isinstance(request, WriteNote):
            if request.at is not None:
                header.stamp = conversions.time_to_msg(request.at)
            note = m.WizardNote(header=header, text=request.text, marker=request.marker)
            self._listened("wizard/note").publish(note)
        elif isinstance(request, BeginSession):
            self._begin.publish(m.NextSession(header=header, session=request.session))
        elif isinstance(request, SubmitForm):
            session = state.session
            name, phase = (session.session, int(session.phase)) if session else ("", 0)
            stamps = (request.opened, conversions.clock_seconds(self._node.get_clock()))
            self._filled.publish(conversions.form_to_msg(request.filled, name, phase, stamps))

    def _press(self, action: Action, state: ConsoleState, header: Header) -> None:
        kind, topic, command = PRESSES[action]
        session = state.session
        paused = (session is not None and session.paused) or state.standing
        aborted = session is not None and session.phase is Phase.ABORTED
        if action is Action.PAUSE and (paused or aborted):
            command = m.WizardCommand.RESUME
        field = "answer" if kind is m.WizardAnswer else "command"
        self._listened(topic).publish(kind(header=header, **{field: command}))

    def _listened(self, topic: str) -> Publisher[Any]:
        """Of a topic to which somebody is connected: what is published to nobody is lost without a word."""
        out = self._out[topic]
        if not out.get_subscription_count():
            raise MbdError(f"nobody listens to {topic} yet, so nothing was sent: press again in a moment")
        return out
