"""Every robot with every camera: a complete session of each pair in the cell, which plays their drivers, as a table."""

from __future__ import annotations

import csv
import itertools
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import above_zero
from mbd_model.errors import MbdError
from mbd_model.folders import make_folder
from mbd_model.session import Phase
from mbd_robot.profiles.find import camera_names, robot_names

from mbd_bringup.nodes import SessionOptions
from mbd_bringup.ros.live_session import LiveSession

TASKS = ("stacking", "sorting", "lunch_packing", "dish_sorting", "assembly")


@dataclass(frozen=True)
class PairSession:
    """How the session of one robot with one camera went.

    Attributes:
        robot, camera: their profiles.
        phase: in which it ended.
        placed: objects that ended where they should.
        places: objects that were to be placed.
        seconds: it took, by the wall clock.
        problem: why it did not get to its end, or an object not to its place; "" when all did.
    """

    robot: str
    camera: str
    phase: str
    placed: int
    places: int
    seconds: float
    problem: str = ""

    @property
    def complete(self) -> bool:
        """Demonstrated, asked, mapped and executed, every object in its place."""
        return self.phase == Phase.DONE.name and self.places > 0 and self.placed == self.places


def pair_session(robot: str, camera: str, *, task: str, seed: int, folder: Path, timeout: float) -> PairSession:
    """Lead one session to its end in the cell.

    The teacher tells every object: it is the robot and the camera that are tried, and a mapping inferred from few
    assists is right as often as it says, not always.

    Args:
        robot: name or file of a profile.
        camera: name or file of a profile.
        task: of the cell.
        seed: of its chance.
        folder: that takes the session's folder.
        timeout: [s]

    Raises:
        MbdError: a profile that cannot be used.
    """
    name = f"{Path(robot).stem}_{Path(camera).stem}"
    options = SessionOptions(
        name, folder / name, task=task, seed=seed, threshold=1.0, speed=0.0, execute=True, robot=robot, camera=camera
    )
    begun, problem = time.monotonic(), ""
    live = LiveSession(options)
    with live:
        try:
            for _ in live.events(timeout):
                pass
        except MbdError as error:
            problem = str(error).splitlines()[0]
        places = live.follower.ending.places()
        live.processes.stop(patience=20.0)
    problem = problem or "; ".join(f"step {p.step + 1}: {p.why}" for p in places if not p.success)
    phase = "none" if live.phase is None else live.phase.name
    return PairSession(
        robot, camera, phase, sum(p.success for p in places), len(places), time.monotonic() - begun, problem
    )  # fmt: skip


def rows(sessions: Sequence[PairSession]) -> list[str]:
    """The table, a line a session."""
    lines = [f"{'robot':14} {'camera':21} {'ended in':12} {'placed':>7} {'time':>7}"]
    for s in sessions:
        place = f"{s.placed} of {s.places}"
        lines.append(f"{s.robot:14} {s.camera:21} {s.phase:12} {place:>7} {s.seconds:5.0f} s  {s.problem}".rstrip())
    return lines


def main(words: Sequence[str] | None = None) -> None:
    """Entry point: exit code 0 when every session was led to its end with every object in its place."""
    parser = CommandParser(prog="robots", description=__doc__)
    parser.add_argument("--robots", nargs="+", metavar="ROBOT", help="names or files (default: all of ours)")
    parser.add_argument("--cameras", nargs="+", metavar="CAMERA", help="names or files (default: all of ours)")
    parser.add_argument("--task", choices=TASKS, default="sorting")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--timeout", type=above_zero, default=600.0, help="give a session up after so many seconds")
    parser.add_argument("--out", type=Path, required=True, help="folder that takes the sessions and robots.csv")
    arguments = parser.parse_args(words)
    pairs = itertools.product(arguments.robots or robot_names(), arguments.cameras or camera_names())
    try:
        make_folder(arguments.out)
        table = arguments.out / "robots.csv"
        if table.exists():
            raise MbdError(f"{table} is there already, and none is ever overwritten; give another --out")
        sessions = []
        with table.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, [f.name for f in fields(PairSession)])
            writer.writeheader()
            for robot, camera in pairs:
                made = pair_session(
                    robot,
                    camera,
                    task=arguments.task,
                    seed=arguments.seed,
                    folder=arguments.out.resolve(),
                    timeout=arguments.timeout,
                )
                sessions.append(made)
                writer.writerow(asdict(made))
                file.flush()
                sys.stdout.write("\n".join(rows([made])[1 if len(sessions) > 1 else 0 :]) + "\n")
                sys.stdout.flush()
    except (MbdError, OSError) as error:
        sys.stderr.write(f"robots: {error}\n")
        sys.exit(1)
    complete = sum(s.complete for s in sessions)
    sys.stdout.write(f"{complete} of {len(sessions)} sessions complete\n")
    sys.exit(complete != len(sessions))
