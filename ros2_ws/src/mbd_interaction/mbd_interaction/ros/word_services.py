"""Each wizard word as a service: it is published on its topic, for all who listen, and answered as the dialogue did.

So a word that was called for reaches the bag, the hand and the demonstration too, from a publisher that has been there
since the session began: ``ros2 topic pub`` leaves before it has found all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from geometry_msgs.msg import Point
from mbd_model.ros.conversions import stamp_to_msg
from mbd_model.ros.qos import EVENTS
from mbd_msgs import msg as m
from mbd_msgs.srv import Say
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.task import Future
from std_msgs.msg import Header

from mbd_interaction.ros.conversions import WIZARD_TOPICS
from mbd_interaction.words import WORDS, WizardWord


class WordServices:
    """Serves ``wizard/<word>`` for each word.

    Args:
        node: which subscribes to the wizard topics itself, and calls ``replied`` with each reply.
        now: the node's time [ns].
    """

    def __init__(self, node: Node, now: Callable[[], int]) -> None:
        self._node, self._now = node, now
        self._out: dict[str, Publisher[Any]] = {
            topic: node.create_publisher(kind, topic, EVENTS) for topic, (kind, _) in WIZARD_TOPICS.items()
        }
        self._waiting: dict[tuple[str, int], Future[m.WizardReply]] = {}
        self._last = 0
        # While a word waits for its answer, the node goes on receiving, that word first of all.
        group = ReentrantCallbackGroup()
        for name, word in WORDS.items():
            node.create_service(Say, f"wizard/{name}", partial(self._say, word), callback_group=group)

    def replied(self, topic: str, stamp: int, reply: m.WizardReply) -> None:
        """The dialogue has answered the event of that topic and stamp [ns]."""
        waiting = self._waiting.pop((topic, stamp), None)
        if waiting is not None:
            waiting.set_result(reply)

    async def _say(self, word: WizardWord, request: Say.Request, response: Say.Response) -> Say.Response:
        # No two words of this node have one stamp, also while a simulated clock stands.
        self._last = stamp = max(self._now(), self._last + 1)
        future: Future[m.WizardReply] = Future(executor=self._node.executor)
        self._waiting[word.topic, stamp] = future
        self._out[word.topic].publish(message_of(word, request, stamp))
        reply = await future
        if reply is None:  # cancelled: this node ends
            response.message = "the dialogue ended before it answered"
            return response
        response.success, response.message, response.sequence = reply.accepted, reply.reason, reply.sequence
        return response


def message_of(word: WizardWord, said: Say.Request, stamp: int) -> Any:
    """The word as the message of its topic, of that stamp [ns]."""
    header = Header(stamp=stamp_to_msg(stamp))
    kind = WIZARD_TOPICS[word.topic][0]
    if kind is m.WizardAnswer:
        return m.WizardAnswer(header=header, answer=word.code)
    if word.code:
        return kind(header=header, command=word.code)
    if kind is m.WizardNote:
        return m.WizardNote(header=header, text=said.text)
    if kind is m.WizardPointed:
        place = Point(x=said.place.x, y=said.place.y, z=said.place.z)
        return m.WizardPointed(header=header, object_id=said.object_id, place=place)
    if kind is m.WizardOverwrite:
        return m.WizardOverwrite(header=header, step_index=said.step_index, object_id=said.object_id)
    if kind is m.WizardRevision:
        return m.WizardRevision(
            header=header,
            change=said.change,
            step=said.step_index,
            to=said.to,
            object=said.object_id,
            at=said.at,
        )
    return m.WizardHanded(header=header, object_id=said.object_id)
