"""Whether tests of reduced size still find faults: plant one at a time into a copy and see which tests fail.

``source env.sh; python tests/planted_faults.py [NUMBER…]`` prints a table for docs/testing.md. The checkout itself is
never touched: the copy's packages come first on PYTHONPATH, also for the nodes that tests start. Exit code 1 when a
fault was not caught, or tests fail where none is planted.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MAPPING = "ros2_ws/src/mbd_mapping/mbd_mapping"
CLOUDS = "ros2_ws/src/mbd_perception/mbd_perception/frames/cloud_files.py"
TRUTH = "ros2_ws/src/mbd_experiments/mbd_experiments/simulated_problems/ground_truth.py"
ENUMERATED = "tests/mbd_mapping/test_mbd_equals_enumeration.py::test_equals_enumeration_over_many_problems"
MOST_PROBABLE = "tests/mbd_mapping/test_evidence.py::test_the_mapping_is_the_most_probable_of_all"
CLOUD_FILES = "tests/mbd_perception/test_cloud_files.py"
TRUE_BEST = "tests/mbd_experiments/test_experiment1.py::test_the_truth_is_the_best_mapping_of_its_set"
RANDOM_EVENTS = "tests/system/test_random_events.py"
KILLED = (
    "tests/mbd_bag/test_recording_rgbd.py"
    "::test_of_20_killed_recordings_every_one_opens_and_lacks_at_most_its_last_second"
)


@dataclass(frozen=True)
class Fault:
    """One change of the source, and the tests of which one must fail for it."""

    what: str
    file: str
    old: str
    new: str
    tests: str


FAULTS = (
    Fault(
        "mbd: the search for the best feature sets ends at the first tie",
        f"{MAPPING}/mbd.py",
        "if self.bounds[f] < best - 2 * self.tolerance:",
        "if self.bounds[f] <= best:",
        ENUMERATED,
    ),
    Fault(
        "mbd: the runner-up is compared with one of several equally good mappings only",
        f"{MAPPING}/mbd.py",
        "shared = columns if unique else detours.best_among_optimal(score, self.tolerance)",
        "shared = columns",
        ENUMERATED,
    ),
    Fault(
        "mbd: only the winning set's ties are counted",
        f"{MAPPING}/mbd.py",
        "for f in self.contenders:\n            if len(found) >= limit:",
        "for f in self.contenders[:1]:\n            if len(found) >= limit:",
        ENUMERATED,
    ),
    Fault(
        "mbd: among more targets than sources, a tie by taking an unused target is missed",
        f"{MAPPING}/assignment/ties.py",
        "may_leave = (left <= tolerance) | (detours.owner == n)",
        "may_leave = (left <= tolerance) & (detours.owner < n)",
        ENUMERATED,
    ),
    Fault(
        "evidence: of the hypotheses of several mappings only the likeliest is looked into",
        f"{MAPPING}/assignment/candidates.py",
        "LIKELIEST = 12",
        "LIKELIEST = 1",
        MOST_PROBABLE,
    ),
    Fault(
        "evidence: mappings within a thousandth of the best count as tied with it",
        f"{MAPPING}/evidence.py",
        "(1.0 - SAME)",
        "(1.0 - 1e-3)",
        MOST_PROBABLE,
    ),
    Fault(
        "evidence: scenes of different size count each mapping once",
        f"{MAPPING}/evidence.py",
        "* likelihoods.of_mappings(squares) * hypotheses.copies",
        "* likelihoods.of_mappings(squares)",
        MOST_PROBABLE,
    ),
    Fault(
        "clouds: the last row of a text file may lack a number",
        CLOUDS,
        "len(rows[-1].split()) < words",
        "len(rows[-1].split()) < words - 1",
        CLOUD_FILES,
    ),
    Fault(
        "clouds: a binary PLY may lack its last tenth",
        CLOUDS,
        "elif len(data) < count * sum(",
        "elif len(data) < 0.9 * count * sum(",
        CLOUD_FILES,
    ),
    Fault(
        "experiment 1: shifts are measured at one pair only",
        TRUTH,
        "itertools.product(range(n), range(m)) if shifting else [(0, 0)]",
        "[(0, 0)]",
        TRUE_BEST,
    ),
    Fault(
        "recorder: what was received is flushed every two seconds",
        "ros2_ws/src/mbd_bag/mbd_bag/recorder/writing_thread.py",
        "if now - flushed >= self._flush_period / 2:",
        "if now - flushed >= 2.0:",
        KILLED,
    ),
    Fault(
        "dialogue node: one in 500 random events, a correction of step 8 to an unknown object, is not answered",
        "ros2_ws/src/mbd_interaction/mbd_interaction/ros/node.py",
        "        if outcome.reply:\n",
        '        if outcome.reply and [vars(event).get(k) for k in ("step_index", "object_id")] != [7, "t9"]:\n',
        RANDOM_EVENTS,
    ),
)


def copied(folder: Path) -> Path:
    """The parts of the checkout that tests need, below ``folder``."""
    for part in ("ros2_ws/src", "tests", "docs", "bags", "requirements"):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def tests_pass(copy: Path, tests: str) -> bool:
    """Whether the tests pass with the copy's packages; raises SystemExit when they could not be run."""
    packages = sorted(str(p.parent) for p in (copy / "ros2_ws" / "src").glob("*/setup.py"))
    path = os.pathsep.join([*packages, os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider", tests]
    done = subprocess.run(
        command, cwd=copy, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=False
    )
    # Interrupted, an internal error, wrong usage, no tests. A test that fails may abort the process by its threads.
    if done.returncode in (2, 3, 4, 5):
        raise SystemExit(f"planted_faults: {tests} could not be run:\n{done.stdout}{done.stderr}")
    return done.returncode == 0


def caught(copy: Path, fault: Fault) -> bool:
    """Plant a fault into the copy, run its tests and take it out again."""
    file = copy / fault.file
    content = file.read_text()
    if content.count(fault.old) != 1:
        raise SystemExit(f"planted_faults: {fault.file} holds {content.count(fault.old)} times: {fault.old}")
    file.write_text(content.replace(fault.old, fault.new))
    try:
        return not tests_pass(copy, fault.tests)
    finally:
        file.write_text(content)


def main(words: Sequence[str]) -> int:
    """Print the table; returns the exit code."""
    chosen = [int(w) for w in words] or range(1, len(FAULTS) + 1)
    missed = 0
    with tempfile.TemporaryDirectory() as scratch:
        copy = copied(Path(scratch))
        for tests in dict.fromkeys(FAULTS[k - 1].tests for k in chosen):
            if not tests_pass(copy, tests):
                raise SystemExit(f"planted_faults: {tests} fails although no fault is planted")
        sys.stdout.write("| | planted fault | found by | caught |\n|---|---|---|---|\n")
        for number in chosen:
            fault = FAULTS[number - 1]
            found = caught(copy, fault)
            missed += not found
            where = Path(fault.tests.partition("::")[0]).name
            sys.stdout.write(f"| {number} | {fault.what} | `{where}` | {'yes' if found else 'NO'} |\n")
            sys.stdout.flush()
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
