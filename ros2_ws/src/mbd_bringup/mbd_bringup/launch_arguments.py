"""The arguments of the session's launch file, and what they mean, without ROS: a launch file's are all words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from mbd_model.errors import MbdError
from mbd_model.parameters import nearest

from mbd_bringup.nodes import SessionOptions

Number = TypeVar("Number", int, float)


@dataclass(frozen=True)
class Argument:
    """One argument: what it is when not given, and what it is for."""

    default: str
    description: str


ARGUMENTS = {
    "session": Argument("session", "name of the session, and of the folder that takes its bag"),
    "folder": Argument("sessions", "folder that takes the sessions' folders"),
    "task": Argument(
        "sorting", "stacking, sorting, lunch_packing, dish_sorting or assembly; with a real robot any name"
    ),
    "seed": Argument("1", "of every random choice in the simulated cell"),
    "strategy": Argument("evidence", "of the mapping: evidence, or mbd, the paper's rule"),
    "threshold": Argument("", "confidence from which the robot goes on alone; empty: the strategy's own (mbd: 0.02)"),
    "simulated": Argument("true", "false expects a real robot and camera"),
    "robot": Argument(
        "", "robot: jaco2, jaco2_2f85, ada, gen3, ur5e, fr3, or the path of a profile of your own (docs/robot.md)"
    ),
    "camera": Argument(
        "", "camera: realsense, realsense_compressed, orbbec, azure_kinect, zed, two_topics, or the path of a profile"
    ),
    "speed": Argument("1.0", "simulated over real time; 0 is as fast as possible"),
    "participant": Argument("", "who teaches, for the bag"),
    "execute": Argument("false", "true: the robot executes the task on the target objects"),
    "scripted_wizard": Argument("true", "false: a person answers, by topics or console; in simulation only"),
    "console": Argument("false", "true: start the operator's web page, http://127.0.0.1:8080"),
    "markers": Argument("true", "publish the session as markers for RViz and Foxglove"),
    "resume": Argument("false", "true: go on with a session of that name that was interrupted"),
}


def refuse_unknown(command_line: Sequence[str]) -> None:
    """Refuse arguments that the launch file does not have: ``ros2 launch`` itself passes them over in silence.

    Args:
        command_line: words of the ``ros2 launch`` that was given this launch file.

    Raises:
        MbdError: a word ``name:=value`` with another name than those of ARGUMENTS; states the nearest right one.
    """
    given = [name for name, given, _ in (word.partition(":=") for word in command_line) if given]
    for name in given:
        if name not in ARGUMENTS:
            near = nearest(name, ARGUMENTS)
            advice = f"did you mean '{near}'?" if near else f"there are: {', '.join(ARGUMENTS)}"
            raise MbdError(f"the session has no launch argument '{name}'; {advice}")


def options_of(words: Mapping[str, str]) -> SessionOptions:
    """The session that these arguments ask for.

    Args:
        words: argument name -> what was given for it; one for each of ARGUMENTS.

    Raises:
        MbdError: a word that cannot be used, or a session that is there and not to be resumed; names the argument.
    """
    options = SessionOptions(
        session=words["session"],
        folder=(Path(words["folder"]).expanduser() / words["session"]).resolve(),
        task=words["task"],
        seed=_number(int, words, "seed", "an integer"),
        strategy=words["strategy"],
        threshold=_number(float, words, "threshold", "a number") if words["threshold"] else None,
        simulated=_yes(words, "simulated"),
        speed=_number(float, words, "speed", "a number"),
        participant=words["participant"],
        execute=_yes(words, "execute"),
        scripted_wizard=_yes(words, "scripted_wizard"),
        console=_yes(words, "console"),
        markers=_yes(words, "markers"),
        resume=_yes(words, "resume"),
        robot=words["robot"],
        camera=words["camera"],
    )
    # A node that cannot start would be started again and again: what it would refuse is refused here, once.
    if (options.bag / "metadata.yaml").exists() and not options.resume:
        raise MbdError(
            f"{options.folder} holds a session already, and none is ever overwritten; "
            f"give another session:=, or go on in it with resume:=true"
        )
    return options


def _number(kind: Callable[[str], Number], words: Mapping[str, str], name: str, expected: str) -> Number:
    try:
        return kind(words[name])
    except ValueError:
        raise MbdError(f"{name}:={words[name]} is not {expected}") from None


def _yes(words: Mapping[str, str], name: str) -> bool:
    if words[name].lower() not in ("true", "false"):
        raise MbdError(f"{name}:={words[name]} is neither true nor false")
    return words[name].lower() == "true"
