"""``say WORD [ARGUMENTS]``: one word of the operator, with the dialogue's answer."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from typing import Any

import rclpy
from geometry_msgs.msg import Point
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import above_zero
from mbd_model.errors import MbdError
from mbd_model.ros.conversions import stamp_to_msg
from mbd_model.ros.starting.command_line import init_ros, other_words
from mbd_msgs.srv import Say
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import Trigger

from mbd_interaction.words import STOP, WORDS, SaidWord, word_named

REFUSED, UNSAID, MISUSED = 1, 3, 2  # exit codes: the dialogue refused it; it was not said or not answered; no such word
FOUND, ANSWERED = 10.0, 60.0  # [s] until the interaction node is taken for absent, and its answer for lost


def _parser() -> argparse.ArgumentParser:
    takes = "\n".join(f"  {name} {word.takes}".rstrip() for name, word in WORDS.items())
    parser = CommandParser(
        prog="say",
        description="Say one word to the dialogue, wait for its answer and print it.",
        epilog=f"words (steps counted from 0, places in metres):\n{takes}\n  {STOP} (everything stands until resume)"
        f"\n\nexit code: 0 taken, {REFUSED} refused, {MISUSED} no such word, {UNSAID} nobody answered",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("word", help="see below")
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="of the word")
    parser.add_argument(
        "--wait", type=above_zero, default=FOUND, help="for the interaction node [s] (default: %(default)g)"
    )
    return parser


def request_of(said: SaidWord) -> Say.Request:
    """What is said as the service takes it."""
    x, y, z = said.place
    return Say.Request(
        object_id=said.object_id,
        place=Point(x=x, y=y, z=z),
        step_index=said.step_index,
        change=said.change,
        to=said.to,
        at=stamp_to_msg(said.at),
        text=said.text,
    )


def say(name: str, arguments: Sequence[str], wait: float) -> tuple[bool, str]:
    """Say a word in a ROS context that is there; returns whether it was taken, and the answer.

    Args:
        name: of the word.
        arguments: as on a command line.
        wait: [s] for the interaction node.

    Raises:
        MbdError: no such word, or no such arguments.
        TimeoutError: nobody is there, or nobody answers.
    """
    kind: Any = Trigger if name == STOP else Say
    service = f"interaction/{STOP}" if name == STOP else f"wizard/{name}"
    if name == STOP and arguments:
        raise MbdError(f"'{arguments[0]}' is one word too many: {STOP} takes nothing")
    request = Trigger.Request() if name == STOP else _asked(name, arguments)
    node = rclpy.create_node("say", use_global_arguments=False)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        client = node.create_client(kind, service)
        if not client.wait_for_service(timeout_sec=wait):
            raise TimeoutError(
                f"nobody serves '{service}': is the session running, and ROS_DOMAIN_ID the same as its own?"
            )
        future = client.call_async(request)
        end = time.monotonic() + ANSWERED
        while not future.done():
            if time.monotonic() > end:
                raise TimeoutError(f"'{service}' did not answer within {ANSWERED:g} s: look at interaction/replies")
            executor.spin_once(timeout_sec=0.1)
        answer = future.result()
        if answer is None:
            raise TimeoutError(f"'{service}' ended without an answer: look at interaction/replies")
        return bool(answer.success), str(answer.message)
    finally:
        executor.shutdown()
        node.destroy_node()


def _asked(name: str, arguments: Sequence[str]) -> Say.Request:
    """The service's request of a word; raises MbdError, which names the word, when it takes no such arguments."""
    word = word_named(name)
    try:
        return request_of(word.parse(arguments))
    except MbdError as error:
        raise MbdError(f"{f'{name} {word.takes}'.strip()}: {error}") from error


def main() -> None:
    """Say it, print the answer, and exit with what became of it."""
    arguments = _parser().parse_args(other_words(sys.argv[1:]))
    try:
        word_named(arguments.word) if arguments.word != STOP else None
        init_ros()
        taken, answer = say(arguments.word, arguments.arguments, arguments.wait)
    except MbdError as error:
        raise SystemExit(_complain(str(error), MISUSED)) from error
    except TimeoutError as error:
        raise SystemExit(_complain(str(error), UNSAID)) from error
    except KeyboardInterrupt:
        raise SystemExit(_complain("interrupted: it may have been said all the same", UNSAID)) from None
    finally:
        rclpy.try_shutdown()
    if not taken:
        raise SystemExit(_complain(f"refused: {answer}", REFUSED))
    sys.stdout.write(f"{answer}\n")


def _complain(text: str, code: int) -> int:
    sys.stderr.write(f"say: {text}\n")
    return code


if __name__ == "__main__":
    main()
