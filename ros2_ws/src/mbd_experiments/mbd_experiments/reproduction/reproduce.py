"""``reproduce --all``: every experiment of the paper, its tables and figures, and the page that compares them."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.session.command_line import run_tool
from mbd_model.command_line.parser import CommandParser
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.local_processes import HERE
from mbd_model.parallel.options import add_executor_options, executor_of
from rich.console import Console

from mbd_experiments.csv_table import CsvRow, write_csv
from mbd_experiments.reproduction.captions import caption
from mbd_experiments.reproduction.reproduction_page import Page, add_case_studies, add_experiment1, add_user_study
from mbd_experiments.reproduction.side_by_side import Results
from mbd_experiments.simulated_problems import experiment1_tool
from mbd_experiments.simulated_problems.case_studies import case_studies, predictions
from mbd_experiments.user_study import experiment2, experiment3
from mbd_experiments.user_study.cases import Case
from mbd_experiments.user_study.experiment_command import read_and_report, session_executor
from mbd_experiments.user_study.predictions import STRATEGY_NAMES
from mbd_experiments.user_study.study_facts import Origin


def case_study_rows() -> list[CsvRow]:
    """What each strategy predicts in the case studies after each assist."""
    rows: list[CsvRow] = []
    for study in case_studies():
        for strategy in STRATEGY_NAMES:
            for count, line in enumerate(predictions(study, strategy)):
                rows.append(
                    {
                        "case": study.name,
                        "strategy": strategy,
                        "assists": count,
                        "predictions": line.predictions,
                        "correct": line.correct,
                        "confidence": f"{line.estimate.confidence:.3f}",
                        "winning": " + ".join(line.estimate.winning),
                    }
                )
    return rows


def run_user_study(cases: Sequence[Case], out: Path, executor: Executor = HERE) -> list[Results]:
    """Experiments 2 and 3 on the sessions of each origin, in a folder each; returns where their tables are."""
    found = []
    for origin in dict.fromkeys(c.origin for c in cases):
        own = [c for c in cases if c.origin is origin]
        folder = out / str(origin)
        experiment2.run(own, folder, STRATEGY_NAMES, executor)
        experiment3.run(own, folder, STRATEGY_NAMES, executor)
        found.append(Results(f"{origin} ({len(own)} sessions)", folder))
    return found


def pictures_of(sources: Sequence[Results], figure: str) -> list[tuple[Path, str]]:
    """The pictures of a figure with their captions."""
    pictures = []
    for source in sources:
        rows = source.table(figure)
        origin = Origin(rows[0]["origin"])
        pictures.append((source.folder / f"{figure}_{origin}.png", caption(figure, origin, rows)))
    return pictures


def _arguments() -> Namespace:
    parser = CommandParser(prog="reproduce", description=__doc__)
    parser.add_argument("--all", action="store_true", help="everything: the default when nothing is chosen")
    parser.add_argument("--experiment1", action="store_true", help="the simulated problems")
    parser.add_argument("--case-studies", action="store_true", help="dish sorting and assembly")
    parser.add_argument("--user-study", action="store_true", help="experiments 2 and 3")
    parser.add_argument("--study", type=Path, help="the public study folder, or a folder of its bags")
    parser.add_argument("--simulated", type=Path, help="folder of a simulated study (see simulate_study)")
    parser.add_argument("--seed", type=int, default=1, help="of experiment 1")
    add_executor_options(parser, "problems and sessions")
    parser.add_argument("--out", type=Path, default=Path("out/reproduction"), help="folder of tables and figures")
    parser.add_argument("--page", type=Path, help="page to write; default: reproduction.md in the folder")
    parser.add_argument("--images", type=Path, help="folder of the page's pictures; default: img beside the page")
    return parser.parse_args()


def _tool() -> int:
    arguments = _arguments()
    console = Console()
    chosen = (arguments.experiment1, arguments.case_studies, arguments.user_study)
    one, two, three = (arguments.all or not any(chosen) or wanted for wanted in chosen)
    folders = [f for f in (arguments.study, arguments.simulated) if f is not None]
    if three and not folders:
        raise BagError(
            "experiments 2 and 3 need sessions: give --study (the public data), --simulated (simulate_study), or both"
        )
    out = arguments.out
    path = arguments.page or out / "reproduction.md"
    page = Page(path, arguments.images or path.parent / "img")
    # What can be refused is read before what takes minutes.
    executor = session_executor(arguments, folders)
    cases = read_and_report(folders, executor, console) if three else ()
    if one:
        experiment1_tool.run(out / "experiment1", executor_of(arguments), seed=arguments.seed)
        add_experiment1(page, out / "experiment1")
    if two:
        add_case_studies(page, write_csv(out / "case_studies.csv", case_study_rows()))
    if three:
        sources = run_user_study(cases, out, executor)
        add_user_study(page, sources, {name: pictures_of(sources, name) for name in ("figure9", "figure10")})
    console.print(f"{page.write()}: paper and project side by side; tables and figures in {out}", highlight=False)
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when a folder cannot be used."""
    run_tool("reproduce", _tool)
