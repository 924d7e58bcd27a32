"""The arguments of the session's launch file, and what they mean, without ROS: a launch file's are all words."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from mbd_model.errors import MbdError
from mbd_model.parameters import nearest

from mbd_bringup.nodes import SessionOptions
from mbd_bringup.planned_words import planned_words

Number = TypeVar("Number", int, float)


@dataclass(frozen=True)
class Argument:
    """One argument: what it is when not given, and what it is for."""

    default: str
    description: str


ARGUMENTS = {
    "session": Argument(
        "", "name of the session, and of the folder that takes its bag; empty: <participant>_<task>, or session"
    ),
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
    "camera_file": Argument(
        "",
        "where the camera stands, as `calibrate` writes it; empty: the cell's, or mbd_bringup/config/jaco2_camera.yaml",
    ),
    "workspace_file": Argument(
        "", "where objects can be; empty: the cell's, or mbd_bringup's jaco2_workspace.yaml, which is to be copied"
    ),
    "lab_prior": Argument("", "what earlier sessions taught the mapping, as `lab_prior` writes it; empty: nothing"),
    "speed": Argument("1.0", "simulated over real time; 0 is as fast as possible"),
    "grasp": Argument("friction", "what keeps an object in the simulated hand: friction, or weld (docs/cell.md)"),
    "participant": Argument("", "who teaches, for the bag"),
    "execute": Argument("false", "true: the robot executes the task on the target objects"),
    "scripted_wizard": Argument(
        "", "false: a person is the operator, by topics or console; empty: true, in simulation without a console"
    ),
    "console": Argument("false", "true: start the operator's web page, http://127.0.0.1:8080"),
    "port": Argument("8080", "of the operator's web page"),
    "language": Argument("en", "of the pages: en, de"),
    "forms": Argument(
        "", "on the participant's page, NAME or NAME@phase each, with commas: consent@observe_source,nasa_tlx@done"
    ),
    "markers": Argument("true", "publish the session as markers for RViz and Foxglove"),
    "resume": Argument("false", "true: go on with a session of that name that was interrupted"),
    "plan": Argument(
        "", "plan.yaml of a study: session, participant, task, seed and the condition's arguments are its next"
    ),
    "deviation": Argument("", "with plan: why this session is not as planned, for its bag"),
}


def given_in(words: Sequence[str]) -> dict[str, str]:
    """Argument name -> value of those words that are ``name:=value``."""
    return {name: value for name, given, value in (word.partition(":=") for word in words) if given}


def refuse_unknown(command_line: Sequence[str]) -> None:
    """Refuse arguments that the launch file does not have: ``ros2 launch`` itself passes them over in silence.

    Args:
        command_line: words of the ``ros2 launch`` that was given this launch file.

    Raises:
        MbdError: a word ``name:=value`` with another name than those of ARGUMENTS; states the nearest right one.
    """
    for name in given_in(command_line):
        if name not in ARGUMENTS:
            raise MbdError(f"the session has no launch argument '{name}'; {_advice(name)}")


def _advice(name: str) -> str:
    near = nearest(name, ARGUMENTS)
    return f"did you mean '{near}'?" if near else f"there are: {', '.join(ARGUMENTS)}"


def options_of(words: Mapping[str, str], given: Collection[str] | None = None) -> SessionOptions:
    """The session that these arguments ask for.

    Args:
        words: argument name -> what was given for it; one for each of ARGUMENTS.
        given: names of those that a person gave; None: those that differ from their defaults.

    Raises:
        MbdError: a word that cannot be used, or a session that is there and not to be resumed; names the argument.
    """
    if given is None:
        given = {name for name, word in words.items() if word != ARGUMENTS[name].default}
    plan: tuple[str, ...] = ()
    if words["plan"]:
        planned = planned_words(words, given)
        words, plan = planned.words, planned.facts
        for name in words:
            if name not in ARGUMENTS:
                raise MbdError(f"the plan's arguments have '{name}', and the session no such; {_advice(name)}")
    elif words["deviation"]:
        raise MbdError("deviation:= states where a plan is left; give the plan too, by plan:=plan.yaml")
    console = _yes(words, "console")
    session = words["session"] or "_".join(filter(None, (words["participant"], words["participant"] and words["task"])))
    session = session or "session"
    options = SessionOptions(
        session=session,
        folder=(Path(words["folder"]).expanduser() / session).resolve(),
        task=words["task"],
        seed=_number(int, words, "seed", "an integer"),
        strategy=words["strategy"],
        threshold=_number(float, words, "threshold", "a number") if words["threshold"] else None,
        simulated=_yes(words, "simulated"),
        speed=_number(float, words, "speed", "a number"),
        grasp=words["grasp"],
        participant=words["participant"],
        execute=_yes(words, "execute"),
        scripted_wizard=_yes(words, "scripted_wizard") if words["scripted_wizard"] else not console,
        console=console,
        markers=_yes(words, "markers"),
        resume=_yes(words, "resume"),
        robot=words["robot"],
        camera=words["camera"],
        camera_file=words["camera_file"],
        workspace_file=words["workspace_file"],
        lab_prior=words["lab_prior"],
        port=_number(int, words, "port", "an integer"),
        forms=tuple(filter(None, (word.strip() for word in words["forms"].split(",")))),
        language=words["language"],
        plan=plan,
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
