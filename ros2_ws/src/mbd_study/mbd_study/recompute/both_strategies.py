"""What each strategy infers of the same recorded inputs, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from mbd_bag.session.recorded_session import RecordedSession
from mbd_mapping.inference import STRATEGIES, infer
from mbd_model.estimate import MappingEstimate
from rich import box
from rich.markup import escape
from rich.table import Table

from mbd_study.recompute.reevaluation import input_of, recorded_config
from mbd_study.tables.correctness import answers_of


@dataclass(frozen=True)
class StrategyRow:
    """One list of assists, by every strategy.

    Attributes:
        num_assists: in force.
        estimates: by strategy.
        right: whether each strategy's mapping is right for every object the task uses; None when nobody knows.
    """

    num_assists: int
    estimates: dict[str, MappingEstimate]
    right: dict[str, bool | None]


def strategy_rows(session: RecordedSession) -> tuple[StrategyRow, ...]:
    """One row for each inference of the session, in the order recorded; one that repeats the one before is left out.

    Each strategy goes on alone from its own threshold; what else was recorded of the parameters holds for all.

    Raises:
        MbdError: the recorded parameters are not of this version.
    """
    answers = answers_of(session)
    rows: list[StrategyRow] = []
    before: object = None
    for recorded, inputs in session.estimates:
        when = recorded.log_time
        task = input_of(session.tasks, inputs.task_stamp, when)
        scene = input_of(session.target_scenes, inputs.scene_stamp, when)
        assists = input_of(session.assists, inputs.assists_stamp, when) or ()
        if task is None or scene is None or before == (inputs.task_stamp, inputs.scene_stamp, assists):
            continue
        before = (inputs.task_stamp, inputs.scene_stamp, assists)
        denials = input_of(session.denials, inputs.assists_stamp, when) or ()
        config = recorded_config(session, recorded.value, inputs.threshold)
        own = {name: replace(config, strategy=name, threshold=None, promise=None) for name in sorted(STRATEGIES)}
        estimates = {name: infer(task, scene, assists, own[name], denials) for name in own}
        used = task.used_objects
        right = {n: None if answers is None else answers.maps_right(e.executed, used) for n, e in estimates.items()}
        rows.append(StrategyRow(len(assists), estimates, right))
    return tuple(rows)


def strategies_table(rows: Sequence[StrategyRow]) -> Table:
    """The rows for a terminal: of each strategy the mapping to carry out, its confidence and whether it is right."""
    table = Table(title="both strategies on the same inputs", title_justify="left", box=box.ROUNDED, show_lines=True)
    table.add_column("#", justify="right", no_wrap=True)
    names = sorted(rows[0].estimates) if rows else sorted(STRATEGIES)
    for name in names:
        table.add_column(name)
    for row in rows:
        table.add_row(str(row.num_assists), *(_cell(row.estimates[n], row.right[n]) for n in names))
    return table


def _cell(estimate: MappingEstimate, right: bool | None) -> str:
    pairs = "  ".join(f"{s}→{t}" for s, t in estimate.executed.pairs) or "none"
    sure = "goes on alone" if estimate.confident else "asks on"
    if estimate.doubted is not None:
        sure = f"doubts {estimate.doubted.source_id}→{estimate.doubted.target_id}"
    verdict = {True: "[green]right[/]", False: "[red]wrong[/]", None: "unknown"}[right]
    return f"{escape(pairs)}\n{estimate.confidence:.3f}, {escape(sure)}, {verdict}"
