"""What is pressed on a page reaches somebody, or the page says that it did not."""

from __future__ import annotations

import pytest
import rclpy
from mbd_console.actions import Action
from mbd_console.requests import AnswerQuestion, Press, PublishedRequest, WriteNote
from mbd_console.ros.wizard_words import WIZARD, WizardWords
from mbd_console.state import ConsoleState
from mbd_model.errors import MbdError
from mbd_model.ros.qos import EVENTS
from rclpy.executors import SingleThreadedExecutor

PRESSED: tuple[PublishedRequest, ...] = (Press(Action.NEXT), AnswerQuestion("t1", pointed=False), WriteNote("a note"))


def test_a_press_that_nobody_would_receive_is_refused_and_arrives_once_somebody_listens(ros_domain: int) -> None:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    try:
        console, dialogue = (rclpy.create_node(name, context=context) for name in ("console", "dialogue"))
        words, came = WizardWords(console), list[object]()
        for request in PRESSED:
            with pytest.raises(MbdError, match=r"nobody listens to wizard/.* press again"):
                words.publish(request, ConsoleState())
        for topic, kind in WIZARD.items():
            dialogue.create_subscription(kind, topic, came.append, EVENTS)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(dialogue)
        left: list[PublishedRequest] = list(PRESSED)
        while left or len(came) < len(PRESSED):
            executor.spin_once(timeout_sec=0.1)
            try:
                if left:
                    words.publish(left[0], ConsoleState())
                    left.pop(0)
            except MbdError:
                continue  # not connected yet
        executor.shutdown()
        assert len(came) == len(PRESSED)
    finally:
        context.try_shutdown()
