"""``simulate_study OUT``: a user study with simulated participants, a bag a session; goes on where it stopped."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.session.command_line import run_tool
from mbd_bag.storage.bag_metadata import FILE_NAME
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import at_least_one
from mbd_model.errors import MbdError
from mbd_model.folders import make_folder
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.options import add_executor_options, executor_of
from mbd_model.share_folder import config_folder
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from mbd_experiments.simulated_participants.error_model import TABLE5, Intention, intentions

PARTICIPANTS = 10
# A layout that the arm cannot work on, or a table perception cannot read, is laid again, as an experimenter would.
ATTEMPTS = 3
ATTEMPT_STRIDE = 1_000_003


@dataclass(frozen=True)
class Finished:
    """One session: the bag, simulated and wall-clock seconds it took, and what went wrong in earlier attempts."""

    bag: Path
    simulated: float
    wall: float
    troubles: tuple[str, ...] = ()


def is_finished(bag: Path) -> bool:
    """Whether a session's bag was closed; one that was cut off lacks its metadata."""
    return (bag / FILE_NAME).exists()


def remaining(study: Sequence[Intention], out: Path) -> list[Intention]:
    """The sessions still to be done; the bags of those that were cut off are removed.

    Raises:
        BagError: something else than a bag of this study is in a session's place, or a bag of another study.
    """
    left = []
    for intention in study:
        bag = out / intention.name
        if is_finished(bag):
            _refuse_other(bag, intention)
            continue
        if bag.exists():
            if not bag.is_dir() or any(p.suffix != ".mcap" for p in bag.iterdir()):
                raise BagError(f"{bag} is no bag that a simulated study left unfinished; give another folder")
            shutil.rmtree(bag)
        left.append(intention)
    return left


def _refuse_other(bag: Path, intention: Intention) -> None:
    from mbd_bag.storage.bag_metadata import read_metadata

    facts = read_metadata(bag).get("custom_data", {})
    if facts.get("study.seed") != str(intention.seed):
        raise BagError(f"{bag} is of a study with another seed; give another folder, or the seed it was begun with")


def simulate(intention: Intention, out: Path, scenes: Path, knowledge: Path) -> Finished:
    """One session into its bag.

    Args:
        intention: who does which task and what he gets wrong.
        out: folder of the bags.
        scenes: folder of the cell's configuration.
        knowledge: perception's knowledge base.

    Raises:
        MbdError: every attempt failed; states why the last one did.
    """
    started = time.perf_counter()
    troubles: list[str] = []
    while True:
        try:
            simulated = _attempt(intention, len(troubles), out / intention.name, scenes, knowledge)
        except MbdError as error:
            shutil.rmtree(out / intention.name, ignore_errors=True)
            troubles.append(str(error))
            if len(troubles) == ATTEMPTS:
                raise MbdError(f"{intention.name} failed {ATTEMPTS} times, at last because {error}") from error
            continue
        return Finished(out / intention.name, simulated, time.perf_counter() - started, tuple(troubles))


def _attempt(intention: Intention, attempt: int, path: Path, scenes: Path, knowledge: Path) -> float:
    """Simulated seconds of a session; raises MbdError when it did not come to its end."""
    # Messages are needed to write bags only; what a session is works without ROS.
    from mbd_bag.session.session_facts import package_versions, parameter_facts
    from mbd_bag.storage.bag_writer import BagWriter
    from mbd_cell.layout.scene_file import load_scenes
    from mbd_mapping.parameters import MAPPING, mapping_config
    from mbd_model.session import Phase

    from mbd_experiments.perceiving import cell_perception, perception_parameters
    from mbd_experiments.ros.cell_conversions import BagTape
    from mbd_experiments.simulated_participants.script import participant_script
    from mbd_experiments.simulated_participants.session import ParticipantSession, Settings
    from mbd_experiments.user_study.study_facts import INTENDED, ORIGIN, SCRIPT, Origin, script_text

    # The features count as exact here, other than at the node: the study was documented so.
    inferring = MAPPING.values({"similarity_noise": 0.0})
    settings = Settings(cell_perception(scenes, knowledge), mapping_config(inferring))
    seed = (intention.seed + attempt * ATTEMPT_STRIDE) % (2**31 - 1)
    script = participant_script(load_scenes(scenes / f"{intention.task}.yaml"), intention, seed)
    facts = {
        "session": intention.name,
        "participant": intention.participant,
        "task": intention.task,
        "seed": str(seed),
        "study.seed": str(intention.seed),
        ORIGIN: str(Origin.SIMULATED),
        SCRIPT: script_text(script.asked),
        INTENDED: intention.words,
    }
    with BagWriter(path) as bag:
        bag.add_facts(facts | package_versions())
        bag.add_facts(parameter_facts("/perception", perception_parameters(scenes)))
        bag.add_facts(parameter_facts("/mapping", inferring | {"threshold": settings.threshold}))
        session = ParticipantSession(intention.name, script, seed, settings, BagTape(intention.name, bag))
        ended = session.run()
        if ended is not Phase.DONE:
            raise MbdError(f"the session ended in {ended.name}")
        return session.seconds


def run_study(
    left: Sequence[Intention], out: Path, *, executor: Executor, scenes: Path, knowledge: Path
) -> Iterator[tuple[Intention, Finished | str]]:
    """Simulate sessions, several at a time; yields each in its turn: done, or why it failed.

    Args:
        left: sessions to do.
        out: folder of the bags.
        executor: who simulates. The workers of a cluster see the three folders under the same paths.
        scenes: folder of the cell's configuration.
        knowledge: perception's knowledge base.

    Raises:
        MbdError: the process of a session was killed from outside, and again when it was tried once more.
    """
    make_folder(out)
    session = partial(_tried, out=out.absolute(), scenes=scenes.absolute(), knowledge=knowledge.absolute())
    return zip(left, executor.run_all(session, left, lambda intention: intention.name), strict=True)


def _tried(intention: Intention, out: Path, scenes: Path, knowledge: Path) -> Finished | str:
    """One session, or why it failed: the others go on."""
    try:
        if not remaining([intention], out):
            # A worker that was killed after the last word has left a complete bag, but nobody knows what it was like.
            shutil.rmtree(out / intention.name)
        return simulate(intention, out, scenes, knowledge)
    except MbdError as error:
        return str(error)


def _tool() -> int:
    parser = CommandParser(prog="simulate_study", description=__doc__)
    parser.add_argument("out", type=Path, help="folder of the bags; of an earlier run to go on with it")
    parser.add_argument("--participants", type=at_least_one, default=PARTICIPANTS)
    parser.add_argument("--seed", type=int, default=1, help="of the study")
    parser.add_argument("--tasks", nargs="+", default=list(TABLE5), choices=list(TABLE5))
    add_executor_options(parser, "sessions")
    arguments = parser.parse_args()
    study = intentions(arguments.participants, arguments.seed, tuple(arguments.tasks))
    left = remaining(study, arguments.out)
    return _show(study, left, arguments.out, executor_of(arguments))


def _show(study: Sequence[Intention], left: Sequence[Intention], out: Path, executor: Executor) -> int:
    scenes = config_folder("mbd_cell")
    knowledge = config_folder("mbd_perception") / "knowledge.yaml"
    console = Console()
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    started, simulated, failed = time.perf_counter(), 0.0, 0
    with Progress(*columns, console=console) as progress:
        bar = progress.add_task("sessions", total=len(study), completed=len(study) - len(left))
        for intention, result in run_study(left, out, executor=executor, scenes=scenes, knowledge=knowledge):
            if isinstance(result, str):
                failed += 1
                text = f"[red]failed[/] {intention.name}: {escape(result)}"
            else:
                simulated += result.simulated
                text = (
                    f"{intention.name}: {intention.words}; {result.simulated:.0f} s in {result.wall:.0f} s"
                    + "".join(f"; laid again: {escape(t)}" for t in result.troubles)
                )
            progress.console.print(text, highlight=False, soft_wrap=True)
            progress.advance(bar)
    wall = time.perf_counter() - started
    speed = f", {simulated / wall:.1f} times real time" if simulated else ""
    console.print(f"{len(left) - failed} sessions simulated in {wall:.0f} s{speed}; {len(study)} in all: {out}")
    return 1 if failed else 0


def main() -> None:
    """Entry point: exit code 0, 1 when a session failed, 2 when the study cannot be run."""
    run_tool("simulate_study", _tool)
