"""``simulate_study OUT``: a whole user study with simulated participants, a bag a session; goes on where it stopped."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import time
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.session.command_line import run_tool
from mbd_bag.storage.bag_metadata import FILE_NAME
from mbd_model.errors import MbdError
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from mbd_experiments.simulated_participants.error_model import TABLE5, Intention, intentions

PARTICIPANTS = 10
# A layout that the arm cannot work on, or a table perception cannot read, is laid anew, as an experimenter would.
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
        MbdError: every attempt failed; says why the last one did.
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
    from mbd_mapping.config import MappingConfig
    from mbd_model.session import Phase

    from mbd_experiments.ros.cell_conversions import BagTape
    from mbd_experiments.simulated_participants.perceiving import perception_config, perception_parameters
    from mbd_experiments.simulated_participants.script import participant_script
    from mbd_experiments.simulated_participants.session import ParticipantSession, Settings
    from mbd_experiments.user_study.study_facts import INTENDED, ORIGIN, SCRIPT, Origin, script_text

    seeing = perception_parameters(scenes)
    settings = Settings(perception_config(seeing, knowledge), MappingConfig())
    script = participant_script(load_scenes(scenes / f"{intention.task}.yaml"), intention)
    seed = (intention.seed + attempt * ATTEMPT_STRIDE) % (2**31 - 1)
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
    mapping = {"strategy": settings.mapping.strategy, "threshold": settings.threshold, "sigma": settings.mapping.sigma}
    with BagWriter(path) as bag:
        bag.add_facts(facts | package_versions())
        bag.add_facts(parameter_facts("/mapping", mapping) | parameter_facts("/perception", seeing))
        session = ParticipantSession(intention.name, script, seed, settings, BagTape(intention.name, bag))
        ended = session.run()
        if ended is not Phase.DONE:
            raise MbdError(f"the session ended in {ended.name}")
        return session.seconds


def run_study(
    left: Sequence[Intention], out: Path, *, jobs: int, scenes: Path, knowledge: Path
) -> Iterator[tuple[Intention, Finished | str]]:
    """Simulate sessions, several at a time; yields each as it ends: done, or why it failed.

    Args:
        left: sessions to do.
        out: folder of the bags.
        jobs: processes at work.
        scenes: folder of the cell's configuration.
        knowledge: perception's knowledge base.

    Raises:
        MbdError: a process was killed from outside.
    """
    out.mkdir(parents=True, exist_ok=True)
    # Forked processes would share this one's GL and thread state.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(max_workers=jobs, mp_context=context) as pool:
        running = {pool.submit(simulate, intention, out, scenes, knowledge): intention for intention in left}
        try:
            for future in as_completed(running):
                try:
                    yield running[future], future.result()
                except MbdError as error:
                    yield running[future], str(error)
        except BrokenProcessPool as error:
            raise MbdError(
                f"a simulating process was killed; the same command goes on where it stopped ({error})"
            ) from error
        finally:
            for future in running:
                future.cancel()


def _tool() -> int:
    parser = ArgumentParser(prog="simulate_study", description=__doc__)
    parser.add_argument("out", type=Path, help="folder of the bags; of an earlier run to go on with it")
    parser.add_argument("--participants", type=int, default=PARTICIPANTS)
    parser.add_argument("--seed", type=int, default=1, help="of the study")
    parser.add_argument("--tasks", nargs="+", default=list(TABLE5), choices=list(TABLE5))
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="sessions at a time; default: a CPU each")
    arguments = parser.parse_args()
    if arguments.jobs < 1:
        raise MbdError(f"--jobs {arguments.jobs}: give 1 or more")
    study = intentions(arguments.participants, arguments.seed, tuple(arguments.tasks))
    left = remaining(study, arguments.out)
    return _show(study, left, arguments.out, arguments.jobs)


def _show(study: Sequence[Intention], left: Sequence[Intention], out: Path, jobs: int) -> int:
    from ament_index_python.packages import get_package_share_directory

    scenes = Path(get_package_share_directory("mbd_cell")) / "config"
    knowledge = Path(get_package_share_directory("mbd_perception")) / "config" / "knowledge.yaml"
    console = Console()
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    started, simulated, failed = time.perf_counter(), 0.0, 0
    with Progress(*columns, console=console) as progress:
        bar = progress.add_task("sessions", total=len(study), completed=len(study) - len(left))
        for intention, result in run_study(left, out, jobs=jobs, scenes=scenes, knowledge=knowledge):
            if isinstance(result, str):
                failed += 1
                text = f"[red]failed[/] {intention.name}: {escape(result)}"
            else:
                simulated += result.simulated
                text = (
                    f"{intention.name}: {intention.words}; {result.simulated:.0f} s in {result.wall:.0f} s"
                    + "".join(f"; laid anew: {escape(t)}" for t in result.troubles)
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
