"""Many trials, several at a time, each with its files: its result, and of a failed one a bag and a picture."""

from __future__ import annotations

import shutil
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

from mbd_model.errors import MbdError
from mbd_model.folders import make_folder
from mbd_model.parallel.executor import Executor

from mbd_experiments.execution_trials.result import TrialCase, TrialResult, read_result, write_result

RESULTS, FAILED = "results", "failed"


@dataclass(frozen=True)
class TrialFolder:
    """Where trials are kept, and what they are made of.

    Attributes:
        out: folder of the run: ``results/`` of all trials, ``failed/`` with a bag, a picture and a sentence of each
            that failed.
        cell_config: folder of the cell's configuration.
        knowledge: perception's knowledge base.
        keep_all: the bags of trials that went well are kept too.
    """

    out: Path
    cell_config: Path
    knowledge: Path
    keep_all: bool = False

    def result(self, case: TrialCase) -> Path:
        """Where the result of a trial is kept."""
        return self.out / RESULTS / f"{case.name}.json"

    def evidence(self, case: TrialCase) -> Path:
        """Folder of a trial's bag and picture."""
        return self.out / FAILED / case.name


def finished(case: TrialCase, folder: TrialFolder) -> TrialResult | None:
    """The result of a trial that was done before, None for one still to do.

    Raises:
        MbdError: what is in its place is no result, or one under other conditions.
    """
    if not folder.result(case).exists():
        return None
    result = read_result(folder.result(case))
    if result.conditions != case.conditions:
        raise MbdError(
            f"{folder.result(case)} is of a trial with {result.conditions}, not with {case.conditions}; give another "
            "folder"
        )
    return result


def run_trials(which: Sequence[TrialCase], folder: TrialFolder, executor: Executor) -> Iterator[TrialResult]:
    """Each trial in its turn; those done before are read.

    Args:
        which: trials.
        folder: where they are kept; the workers of a cluster see it under the same path.
        executor: who runs them.

    Raises:
        MbdError: the folder holds something else.
    """
    make_folder(folder.out / RESULTS)
    whole = replace(
        folder,
        out=folder.out.absolute(),
        cell_config=folder.cell_config.absolute(),
        knowledge=folder.knowledge.absolute(),
    )
    return executor.run_all(partial(run_case, whole), which, lambda case: case.name)


def run_case(folder: TrialFolder, case: TrialCase) -> TrialResult:
    """One trial, unless it was done before.

    Raises:
        MbdError: its files cannot be written.
    """
    before = finished(case, folder)
    if before is not None:
        return before
    # Messages and rendering are needed here only, not by who prints a table.
    from mbd_bag.session.session_facts import package_versions
    from mbd_bag.storage.bag_writer import BagWriter
    from mbd_cell.layout.scene_file import load_scenes

    from mbd_experiments.execution_trials.evidence import write_picture
    from mbd_experiments.execution_trials.trial_session import TrialSession, Tried
    from mbd_experiments.perceiving import cell_perception
    from mbd_experiments.ros.cell_conversions import BagTape

    started = time.monotonic()
    shutil.rmtree(folder.evidence(case), ignore_errors=True)
    make_folder(folder.evidence(case))
    try:
        shipped = load_scenes(folder.cell_config / f"{case.task}.yaml")
        perception = cell_perception(folder.cell_config, folder.knowledge)
        with BagWriter(folder.evidence(case) / "bag") as bag:
            bag.add_facts({f"trial.{key}": str(value) for key, value in asdict(case).items()} | package_versions())
            tried = TrialSession(case, shipped, perception, BagTape(case.name, bag)).run()
    except MbdError as error:
        tried = Tried(TrialResult(case.task, case.seed, case.conditions, right=False, why=f"not begun: {error}"))
    except Exception as error:  # whatever broke in one trial, the others go on
        (folder.evidence(case) / "trace.txt").write_text(traceback.format_exc(), encoding="utf-8")
        why = f"the program broke: {type(error).__name__}: {error}"
        # Not kept: once it is mended the trial is done again.
        return TrialResult(case.task, case.seed, case.conditions, right=False, why=why)
    result = replace(tried.result, wall=round(time.monotonic() - started, 1))
    if not result.right:
        (folder.evidence(case) / "why.txt").write_text(f"{result.sentence}\n", encoding="utf-8")
        if tried.before is not None and tried.after is not None:
            write_picture(folder.evidence(case) / "before_and_after.png", tried.before, tried.after, result.sentence)
    elif not folder.keep_all:
        shutil.rmtree(folder.evidence(case), ignore_errors=True)
    write_result(folder.result(case), result)
    return result
