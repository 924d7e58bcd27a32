"""``import_study DIR OUT``: turn the public user-study folder into session bags like those a recorder writes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from mbd_bag.errors import BagError
from mbd_bag.session.command_line import run_tool
from mbd_bag.session.recorded_session import Recorded, RecordedSession, TrueObject, Truth
from mbd_bag.session.session_facts import package_versions, parameter_facts
from mbd_mapping.config import MappingConfig, MissingHue
from mbd_mapping.inference import infer
from mbd_model.assists import Assist, AssistKind
from mbd_model.command_line.parser import CommandParser
from mbd_model.estimate import EstimateInputs
from mbd_model.objects import Role, Scene
from mbd_model.session import Phase, Prompt, PromptKind, SessionState
from mbd_model.task import StepKind, Task, TaskStep
from mbd_model.times import to_nanoseconds, to_seconds
from rich.console import Console

from mbd_experiments.public_study.study_folder import SESSION, StudySession, read_study
from mbd_experiments.user_study.study_facts import ORIGIN, REAL_SCRIPTS, SCRIPT, TASK_NAMES, Origin, script_text

# The numbers of the paper come with the missing hue taken as the study's program took it.
STUDY_THRESHOLD = 0.02
STUDY_CONFIG = MappingConfig("mbd", threshold=STUDY_THRESHOLD, missing_hue=MissingHue.AS_RECORDED)
# The folder holds no times. These only order what happened: seconds from the start of a session.
SOURCE_SEEN, DEMONSTRATED, TARGET_SEEN, ASSISTS_BEGIN, BETWEEN_ASSISTS, UNTIL_ESTIMATE = 1, 30, 40, 41, 4, 0.5
STEP_SECONDS = 2.0
PARAMETERS = ("strategy", "threshold", "sigma", "feature_space", "missing_hue", "hue_tolerance", "size_tolerance")


def recorded_session(session: StudySession, config: MappingConfig = STUDY_CONFIG) -> RecordedSession:
    """What a recorder would have written in that session.

    The study's robot asked at every step. So there is a question, an assist and an estimate for each assist of the
    folder, after an estimate without any.

    Args:
        session: as read from the folder.
        config: of the mapping.

    Raises:
        BagError: the session's name contains no task of the study.
    """
    match = SESSION.fullmatch(session.name)
    if match is None or int(match[2]) >= len(TASK_NAMES):
        raise BagError(f"session '{session.name}' is none of the study's; expected u<participant>_t<0, 1 or 2>")
    name = TASK_NAMES[int(match[2])]
    source = replace(session.task.source, stamp=float(SOURCE_SEEN))
    target = replace(session.target, stamp=float(TARGET_SEEN))
    steps = tuple(_timed(step) for step in session.task.steps)
    task = Task(source, steps, session.task.problems, float(DEMONSTRATED))
    end = ASSISTS_BEGIN + BETWEEN_ASSISTS * (len(session.assists) + 1)
    phases = {
        0.5: Phase.OBSERVE_SOURCE,
        SOURCE_SEEN + 0.1: Phase.DEMONSTRATE,
        DEMONSTRATED + 0.1: Phase.TUCK_AND_CLEAR,
        TARGET_SEEN - 0.5: Phase.OBSERVE_TARGET,
        TARGET_SEEN + 0.1: Phase.ASSIST,
        end: Phase.EXECUTE,
        end + 1.0: Phase.DONE,
    }
    given = tuple(
        replace(a, kind=_kind(task.steps[a.step_index]), stamp=_given_at(k)) for k, a in enumerate(session.assists, 1)
    )
    facts = {
        "session": session.name,
        "participant": f"u{match[1]}",
        "task": name,
        ORIGIN: str(Origin.REAL),
        SCRIPT: script_text(REAL_SCRIPTS[name]),
    }
    values = {key: getattr(config, key) for key in PARAMETERS}
    values = {key: str(value) if isinstance(value, str) else value for key, value in values.items()}
    return RecordedSession(
        name=session.name,
        facts=facts | package_versions() | parameter_facts("/mapping", values),
        source_scenes=(_at(source, source.stamp),),
        target_scenes=(_at(target, target.stamp),),
        tasks=(_at(task, task.stamp),),
        states=tuple(
            _at(SessionState(session.name, phase, assists=given if phase >= Phase.EXECUTE else ()), seconds)
            for seconds, phase in phases.items()
        ),
        truths=tuple(_at(_truth(scene, session, name), scene.stamp - 0.2) for scene in (source, target)),
        **_dialogue(task, target, given, config),
    )


def _timed(step: TaskStep) -> TaskStep:
    start = SOURCE_SEEN + 1.0 + STEP_SECONDS * step.index
    return replace(step, start=start, end=start + STEP_SECONDS)


def _given_at(number: int) -> float:
    return float(ASSISTS_BEGIN + BETWEEN_ASSISTS * number)


def _kind(step: TaskStep) -> AssistKind:
    return AssistKind.HANDED if step.kind is StepKind.PICK else AssistKind.POINTED


def _at(value: Any, seconds: float) -> Recorded[Any]:
    return Recorded(value, to_nanoseconds(seconds), to_nanoseconds(seconds))


def _truth(scene: Scene, session: StudySession, task: str) -> Truth:
    """What is known of the table: the recorded objects, and the study's solution."""
    # Ids name the same thing only within a set, so an object is known by its id.
    things = tuple(TrueObject(o.object_id, o.centroid, o.size, o.hue) for o in scene.objects)
    return Truth(task, scene.role, 0, things, session.solution if scene.role is Role.TARGET else {})


def _dialogue(task: Task, target: Scene, given: tuple[Assist, ...], config: MappingConfig) -> dict[str, Any]:
    prompts, assists, estimates = [], [_at((), ASSISTS_BEGIN)], []
    for count in range(len(given) + 1):
        if count:
            step = task.steps[given[count - 1].step_index]
            asks = step.kind is StepKind.PICK
            prompt = Prompt(
                PromptKind.WHAT_DO_I_USE if asks else PromptKind.WHERE_DO_I_GO,
                "What do I use now?" if asks else "Where do I go next?",
                step.index,
                step.primary_object,
            )
            prompts.append(_at(prompt, _given_at(count) - 1.0))
            assists.append(_at(given[:count], _given_at(count)))
        estimate = infer(task, target, given[:count], config)
        inputs = EstimateInputs(
            task_stamp=to_nanoseconds(task.stamp),
            scene_stamp=to_nanoseconds(target.stamp),
            assists_stamp=assists[-1].stamp,
            threshold=STUDY_THRESHOLD,
            confident=estimate.confidence >= STUDY_THRESHOLD,
        )
        estimates.append((_at(estimate, to_seconds(assists[-1].stamp) + UNTIL_ESTIMATE), inputs))
    return {"prompts": tuple(prompts), "assists": tuple(assists), "estimates": tuple(estimates)}


def import_study(folder: Path, out: Path) -> list[Path]:
    """Write a bag for each session of the folder.

    Args:
        folder: the public study folder (data/hri17 of its repository).
        out: folder of the bags to write, one named as each session.

    Returns:
        The bags.

    Raises:
        StudyFolderError: a file of the study folder is missing or not as described.
        BagError: one of the bags exists already.
    """
    # Messages are needed to write bags only; what stands above works without ROS.
    from mbd_bag.ros.session_conversions import session_to_bag
    from mbd_bag.storage.bag_writer import BagWriter

    sessions = [recorded_session(s) for s in read_study(folder)]
    bags = [out / s.name for s in sessions]
    if there := [str(b) for b in bags if b.exists()]:
        raise BagError(f"{', '.join(there)} exist(s) already; bags are never overwritten: give another folder")
    for session, path in zip(sessions, bags, strict=True):
        with BagWriter(path) as bag:
            session_to_bag(session, bag)
    return bags


def _tool() -> int:
    parser = CommandParser(prog="import_study", description=__doc__)
    parser.add_argument("folder", type=Path, help="the public study folder, data/hri17")
    parser.add_argument("out", type=Path, help="folder to write the bags into")
    arguments = parser.parse_args()
    bags = import_study(arguments.folder, arguments.out)
    Console().print(f"{len(bags)} sessions of the user study are in {arguments.out}, a bag each", highlight=False)
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when the folder cannot be used."""
    run_tool("import_study", _tool)
