"""Film a complete session of the simulated cell: what the teacher shows, what the robot asks, what it does.

Nothing is staged: it is the session that `execution_trials` counts, of the same task, seed and grasp.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from mbd_bag.session.command_line import run_tool
from mbd_cell.adversary import TableDisturbance
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.physics.grasp import Grasp
from mbd_model.command_line.parser import CommandParser
from mbd_model.folders import make_folder
from mbd_model.session import Phase
from mbd_model.share_folder import config_folder
from rich.console import Console

from mbd_experiments.execution_trials.result import TASKS, TrialCase
from mbd_experiments.execution_trials.trial_session import TrialSession
from mbd_experiments.in_process_session import NoTape
from mbd_experiments.perceiving import cell_perception
from mbd_experiments.session_video.film import WRITERS, Film

PRINT = Console(highlight=False, soft_wrap=True)
LARGEST = 4 * 2**20  # [bytes]
LETTERS = 84  # of a line of the caption
WHAT = {
    Phase.OBSERVE_SOURCE: "the robot looks at what is to be shown",
    Phase.DEMONSTRATE: "the teacher shows the task by hand",
    Phase.TUCK_AND_CLEAR: "other objects are laid on the table",
    Phase.OBSERVE_TARGET: "the robot looks at the new objects",
    Phase.ASSIST: "the robot asks",
    Phase.EXECUTE: "the robot does the task with the new objects",
    Phase.DONE: "done",
}


def main(words: Sequence[str] | None = None) -> None:
    """Entry point: exit code 0, 1 when the filmed session was not right, 2 when there is no film."""
    run_tool("session_video", lambda: _tool(words))


def _tool(words: Sequence[str] | None) -> int:
    parser = CommandParser(
        prog="session_video", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path, help=f"the film: a file ending in {' or '.join(WRITERS)}")
    parser.add_argument("--task", choices=TASKS, default="sorting")
    parser.add_argument("--seed", type=int, default=2, help="of object sets, layouts and noise (default 2)")
    parser.add_argument("--grasp", choices=[*Grasp], default=str(Grasp.FRICTION), help="what keeps things in the hand")
    parser.add_argument("--disturb", nargs="*", choices=[*TableDisturbance], default=[], help="what an adversary does")
    parser.add_argument("--faster", type=float, default=8.0, help="how many times faster than real time (default 8)")
    given = parser.parse_args(words)
    if given.out.suffix not in WRITERS:
        parser.error(f"'{given.out.name}' must end in {' or '.join(WRITERS)}")
    if not 1.0 <= given.faster <= 100.0:
        parser.error(f"--faster {given.faster}: from 1 to 100")
    if given.seed < 0:
        parser.error(f"--seed {given.seed}: 0 or more")
    make_folder(given.out.parent)  # before minutes of filming
    cell_config = config_folder("mbd_cell")
    case = TrialCase(given.task, given.seed, Grasp(given.grasp), tuple(TableDisturbance(d) for d in given.disturb))
    seen = cell_perception(cell_config, config_folder("mbd_perception") / "knowledge.yaml")
    trial = TrialSession(case, load_scenes(cell_config / f"{given.task}.yaml"), seen, NoTape())
    film = Film(trial.cell, given.faster, lambda: _caption(trial, given.faster))
    trial.watch(film.tick)
    try:
        result = trial.run().result
    finally:
        film.close()
    size = film.write(given.out)
    PRINT.print(
        f"{given.out}: {len(film.images)} images, {size / 2**20:.2f} MiB, grasp by {given.grasp}, "
        f"{given.faster:g} times real time; {result.sentence}",
        markup=False,
    )
    if size > LARGEST:
        PRINT.print("it is larger than 4 MiB: film it with a higher --faster")
    return 0 if result.right else 1


def _caption(trial: TrialSession, faster: float) -> tuple[str, str]:
    """What happens, and what the robot says of it."""
    case, dialogue = trial.case, trial.dialogue
    what = WHAT.get(dialogue.phase, "")
    said = dialogue.detail if dialogue.phase in (Phase.ASSIST, Phase.EXECUTE) else ""
    if dialogue.phase is Phase.EXECUTE:
        said = trial.disturbed[-1] if trial.disturbed else dialogue.progress.text if dialogue.progress else said
    return f"{case.task}, grasp by {case.grasp}, x{faster:g}: {what}"[:LETTERS], said[:LETTERS]


if __name__ == "__main__":
    main()
