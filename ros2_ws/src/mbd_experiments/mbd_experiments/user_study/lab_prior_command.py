"""``lab_prior FOLDER...``: learn from the finished sessions of a lab what its next ones are likely to be about.

Writes ``lab_prior.json``, the counts, and ``lab_prior.yaml``, the parameters that give them to the mapping node. With
``--check`` nothing is written: it prints what the prior does to the sessions of each participant when it is learned
from those of the others, and the same with a history of random features.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import yaml
from mbd_bag.errors import BagError
from mbd_bag.session.command_line import open_session, run_tool
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_mapping.teachers.lab_prior import FEATURES, LabPrior
from mbd_model.command_line.parser import CommandParser
from mbd_model.errors import MbdError
from mbd_model.folders import make_folder
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from mbd_experiments.public_study.study_folder import read_study
from mbd_experiments.user_study.cases import bags_in, read_cases
from mbd_experiments.user_study.lab_history import COUNTS, HistoryScore, ends_of, left_out, shuffled

CONFIG = MappingConfig(strategy="evidence")


def learned(folders: Sequence[Path], console: Console, known: LabPrior | None = None) -> LabPrior:
    """What the sessions of the folders teach; which mapping was right need not be known.

    Args:
        folders: the public study folder, or folders of bags.
        console: where bags that hold no assists are named.
        known: what was learned before; None: nothing.

    Raises:
        BagError: a folder holds no session, or none of the sessions has an assist.
    """
    prior = known or LabPrior()
    before = prior.sessions
    for folder in folders:
        if (folder / "solutions").is_dir():
            for found in read_study(folder):
                if found.assists:
                    prior = prior.after(infer(found.task, found.target, found.assists, CONFIG), found.assists)
            continue
        bags = bags_in(folder)
        if not bags:
            raise BagError(f"{folder} is neither the public study folder nor a folder of session bags")
        for path in bags:
            try:
                _, session = open_session(path)
                if not (session.tasks and session.target_scenes and session.assists and session.assists[-1].value):
                    raise BagError("it ended before the first assist")
                assists = session.assists[-1].value
                end = infer(session.tasks[-1].value, session.target_scenes[-1].value, assists, CONFIG)
                prior = prior.after(end, assists)
            except MbdError as error:
                console.print(f"[yellow]left out:[/] {escape(f'{path}: {error}')}", highlight=False, soft_wrap=True)
    if prior.sessions == before:
        raise BagError(f"no session of {', '.join(map(str, folders))} has an assist to learn from")
    return prior


def write_parameters(prior: LabPrior, path: Path) -> None:
    """A ROS parameter file that gives the mapping node what was learned."""
    config = prior.applied_to(CONFIG)
    values = {
        "feature_prior": [round(f, 4) for f in config.priors.features],
        "assist_error": round(config.assist_error, 4),
    }
    text = yaml.safe_dump({"/**/mapping": {"ros__parameters": values}}, sort_keys=False)
    path.write_text(
        f"# Learned from {prior.sessions} sessions: mapping --ros-args --params-file {path.name}\n{text}",
        encoding="utf-8",
    )


def _shown(prior: LabPrior) -> Table:
    config = prior.applied_to(CONFIG)
    table = Table("feature", "sessions", "weight")
    for feature, uses, weight in zip(FEATURES, prior.uses, config.priors.features, strict=True):
        table.add_row(str(feature), f"{uses:.2f}", f"{weight:.2f}")
    return table


def check(folders: Sequence[Path], shuffles: int, seed: int, console: Console) -> Table:
    """A row each without a prior, with the history as it was, and with shuffled ones, and the shuffled ones' mean.

    Raises:
        BagError: no session states which mapping is right, or all are of one participant.
    """
    cases, refused = read_cases(folders)
    for entry in refused:
        console.print(f"[yellow]left out:[/] {escape(f'{entry.path}: {entry.reason}')}", soft_wrap=True)
    ends, rng = ends_of(cases, CONFIG), np.random.default_rng(seed)
    table = Table(box=None)
    for name in ("history", *(f"k = {k}" for k in COUNTS), "all", "log P(right)", "informs"):
        table.add_column(name, no_wrap=True)

    def add(name: str, scores: Sequence[HistoryScore]) -> None:
        right = np.mean([s.right for s in scores], axis=0)
        table.add_row(
            name,
            *(f"{r:.3g}" for r in right),
            f"{np.mean([s.log_probability for s in scores]):.3f}",
            f"{np.mean([s.informs for s in scores]):.2f}",
        )

    add("none", [left_out(cases, None, CONFIG)])
    add("of the others", [left_out(cases, ends, CONFIG)])
    at_random = []
    for number in range(1, shuffles + 1):
        at_random.append(left_out(cases, shuffled(ends, rng), CONFIG))
        add(f"shuffled, {number}", at_random[-1:])
    if at_random:
        add("shuffled, mean", at_random)
    console.print(f"best guess right, of {len(cases)} sessions, by assists; history of the other participants")
    return table


def _tool() -> int:
    parser = CommandParser(prog="lab_prior", description=__doc__)
    parser.add_argument("folders", type=Path, nargs="+", help="the public study folder, or folders of session bags")
    parser.add_argument("--out", type=Path, default=Path(), help="folder to write into")
    parser.add_argument("--add-to", type=Path, help="a lab_prior.json of earlier sessions to add these to")
    parser.add_argument("--check", action="store_true", help="print what it would have done; write nothing")
    parser.add_argument("--shuffles", type=int, default=5, help="shuffled histories of --check")
    parser.add_argument("--seed", type=int, default=1, help="of the shuffled histories")
    arguments = parser.parse_args()
    console = Console()
    if arguments.check:
        console.print(check(arguments.folders, arguments.shuffles, arguments.seed, console))
        return 0
    prior = learned(arguments.folders, console, LabPrior.read(arguments.add_to) if arguments.add_to else None)
    make_folder(arguments.out)
    counts, parameters = arguments.out / "lab_prior.json", arguments.out / "lab_prior.yaml"
    prior.write(counts)
    write_parameters(prior, parameters)
    console.print(_shown(prior))
    console.print(
        f"{prior.sessions} sessions, {prior.wrong} of {prior.assists} assists wrong; tasks prefer some features with "
        f"probability {prior.informs:.2f}\n{escape(str(counts))}\n{escape(str(parameters))}",
        highlight=False,
        soft_wrap=True,
    )
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when the folders cannot be used."""
    run_tool("lab_prior", _tool)
