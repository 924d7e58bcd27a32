"""What the experiments need of a session, whether it was read from the study's files or from a bag."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.session.command_line import open_session
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.storage.bag_paths import bags_below
from mbd_mapping.config import MappingConfig
from mbd_model.assists import Assist
from mbd_model.errors import MbdError
from mbd_model.objects import Scene
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.local_processes import HERE
from mbd_model.task import Task
from mbd_study.recompute.reevaluation import recorded_config
from mbd_study.tables.correctness import answers_of

from mbd_experiments.public_study.study_folder import SESSION, StudySession, read_study
from mbd_experiments.user_study.answers import FILE_NAME, AnswerSheet, read_answers
from mbd_experiments.user_study.import_study import STUDY_CONFIG
from mbd_experiments.user_study.study_facts import ORIGIN, REAL_SCRIPTS, TASK_NAMES, Origin, Pairs, script_from


@dataclass(frozen=True)
class Case:
    """One session with its right answers.

    Attributes:
        name: of the session.
        participant, task_name: who and what.
        origin: real or simulated.
        task: as demonstrated.
        target: the scene it is carried over to.
        assists: all that were given, oldest first.
        acceptable: right target ids by source id.
        script: the (picked, placed onto) source ids that were asked for; () when not known.
        config: of the mapping, as the session had it.
    """

    name: str
    participant: str
    task_name: str
    origin: Origin
    task: Task
    target: Scene
    assists: tuple[Assist, ...]
    acceptable: Mapping[str, frozenset[str]]
    script: Pairs
    config: MappingConfig

    def solved_by(self, mapping: Mapping[str, str]) -> bool:
        """True when every object the demonstration uses goes to an acceptable target."""
        used = self.task.used_objects
        return bool(used) and all(mapping.get(s) in self.acceptable.get(s, frozenset()) for s in used)


@dataclass(frozen=True)
class LeftOut:
    """A bag that no experiment can use, and why."""

    path: Path
    reason: str


def case_of_files(session: StudySession) -> Case:
    """A session of the study folder."""
    match = SESSION.fullmatch(session.name)
    number = int(match[2]) if match else -1
    task_name = TASK_NAMES[number] if 0 <= number < len(TASK_NAMES) else session.name
    return Case(
        name=session.name,
        participant=session.name.partition("_")[0],
        task_name=task_name,
        origin=Origin.REAL,
        task=session.task,
        target=session.target,
        assists=session.assists,
        acceptable=session.solution,
        script=REAL_SCRIPTS.get(task_name, ()),
        config=STUDY_CONFIG,
    )


def case_of_session(session: RecordedSession, answer: AnswerSheet | None = None) -> Case:
    """A recorded session, ids as perceived.

    Args:
        session: as recorded.
        answer: what its experimenter states is right; None: what the cell's truth in it states.

    Raises:
        BagError: it did not come to the assists, nothing states what is right, or the answer is not of this session.
    """
    if not session.tasks or not session.target_scenes:
        raise BagError(f"session '{session.name}' holds no task or no target scene: it ended before the assists")
    task, target = session.tasks[-1].value, session.target_scenes[-1].value
    facts = session.facts
    known = {str(o) for o in Origin}
    # Only a simulated cell knows its own truth; an import states that it is real.
    origin = Origin(facts[ORIGIN]) if facts.get(ORIGIN) in known else Origin.SIMULATED if session.truths else Origin.OWN
    if answer is not None:
        answer.check(session)
        acceptable, script = answer.right, answer.script
    else:
        acceptable, script = _by_truth(session)
    config = MappingConfig()
    if session.estimates:
        recorded, inputs = session.estimates[-1]
        config = recorded_config(session, recorded.value, inputs.threshold)
    return Case(
        name=session.name,
        participant=facts.get("participant", session.name),
        task_name=facts.get("task") or next((t.value.task for t in session.truths), "unnamed task"),
        origin=origin,
        task=task,
        target=target,
        assists=session.assists[-1].value if session.assists else (),
        acceptable=acceptable,
        script=script,
        config=config,
    )


def _by_truth(session: RecordedSession) -> tuple[Mapping[str, frozenset[str]], Pairs]:
    """Acceptable targets and script by what the simulated cell published of its objects."""
    answers = answers_of(session)
    if answers is None or not answers.right:
        raise BagError(
            f"session '{session.name}' holds no truth, so nothing states which mapping is right; "
            f"write it into {FILE_NAME} (`answers FOLDER` makes the sheet)"
        )
    sources, targets = session.tasks[-1].value.source.ids, session.target_scenes[-1].value.ids
    id_of = {name: perceived for perceived, name in answers.source_names.items()}
    # An object that perception did not find keeps its true name, which no step can have.
    script = ((id_of.get(p, f"{p} (unseen)"), id_of.get(o, f"{o} (unseen)")) for p, o in script_from(session.facts))
    return {s: frozenset(t for t in targets if answers.is_right(s, t)) for s in sources}, tuple(script)


def bags_in(folder: Path) -> tuple[Path, ...]:
    """The bags of a folder by name, itself when it is one; without first tries that were recorded again."""
    try:
        return tuple(bags_below([folder]))
    except BagError:
        return ()


def read_cases(sources: Sequence[Path], executor: Executor = HERE) -> tuple[tuple[Case, ...], tuple[LeftOut, ...]]:
    """Every session of the given folders, each the public study folder or a folder of bags.

    Args:
        sources: the folders.
        executor: who reads the bags.

    Returns:
        The cases by origin, task and name, and the bags that no experiment can use.

    Raises:
        BagError: a folder holds no session at all.
    """
    cases: list[Case] = []
    left_out: list[LeftOut] = []
    for source in sources:
        if (source / "solutions").is_dir():
            cases += [case_of_files(s) for s in read_study(source)]
            continue
        bags = bags_in(source)
        if not bags:
            raise BagError(f"{source} is neither the public study folder nor a folder of session bags")
        read = partial(_read_bag, read_answers(source))
        for path, result in zip(bags, executor.run_all(read, [bag.absolute() for bag in bags]), strict=True):
            if isinstance(result, str):
                left_out.append(LeftOut(path, result))
            elif (result.origin, result.name) in {(c.origin, c.name) for c in cases}:
                left_out.append(LeftOut(path, f"another bag holds session '{result.name}' already"))
            else:
                cases.append(result)
    if not cases:
        reasons = "; ".join(f"{entry.path}: {entry.reason}" for entry in left_out[:3])
        raise BagError(f"none of {len(left_out)} bags can be used: {reasons}")
    order = {name: k for k, name in enumerate(TASK_NAMES)}
    cases.sort(key=lambda c: (c.origin, order.get(c.task_name, len(order)), c.task_name, c.name))
    return tuple(cases), tuple(left_out)


def sessions_in(sources: Sequence[Path]) -> int:
    """About how many sessions the folders hold."""
    return sum(len(bags_in(source)) for source in sources)


def _read_bag(answers: Mapping[str, AnswerSheet], path: Path) -> Case | str:
    """What a bag holds, or why it cannot be used."""
    try:
        _, session = open_session(path)
        return case_of_session(session, answers.get(session.name))
    except MbdError as error:
        return str(error)
