"""``table BAG``: a session assist by assist: what was asked and answered, and what the robot then believed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mbd_bag.session.command_line import bag_parser, read_session, run_tool
from mbd_bag.session.recorded_session import RecordedSession
from mbd_model.assists import Assist, AssistKind
from mbd_model.estimate import Feature, Mapping, MappingEstimate
from mbd_model.session import PromptKind
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from mbd_study.recompute.reevaluation import input_of
from mbd_study.tables.correctness import answers_of

NO_QUESTION = (PromptKind.INFORM, PromptKind.WHICH_WAS_MEANT)  # about the target objects


@dataclass(frozen=True)
class AssistRow:
    """One estimate and the assist that led to it.

    Attributes:
        num_assists: in force.
        step_index: 0-based step asked about; -1 before the first assist and after a withdrawal.
        asked: the prompt's text; "" when nothing was asked.
        answered: the target object given, with how; what was withdrawn; "".
        pairs: (source id, target id) predicted.
        confidence: of the prediction, 0..1.
        confident: whether it reached the threshold.
        ties: mappings sharing the best score.
        winning: the feature set.
        best_guess: the most probable mapping when assists may be wrong; empty where an older version named none.
        obeying: the most probable one that holds every assist.
        doubted: the assist that is probably wrong, and how probably; "" for none.
        correct: right for every object the task uses; None when nobody knows.
        wrong: source ids mapped to a wrong target, as far as known.
    """

    num_assists: int
    step_index: int
    asked: str
    answered: str
    pairs: tuple[tuple[str, str], ...]
    confidence: float
    confident: bool
    ties: int
    winning: tuple[Feature, ...]
    best_guess: Mapping
    obeying: Mapping
    doubted: str
    correct: bool | None
    wrong: frozenset[str]


def assist_rows(session: RecordedSession) -> tuple[AssistRow, ...]:
    """One row for each inference, in the order recorded; one that repeats the one before (a restart) is left out."""
    rows: list[AssistRow] = []
    answers = answers_of(session)
    before: tuple[Assist, ...] = ()
    last: object = None
    for recorded, inputs in session.estimates:
        estimate = recorded.value
        given = input_of(session.assists, inputs.assists_stamp, recorded.log_time) or ()
        inference = (inputs.task_stamp, inputs.scene_stamp, inputs.threshold, given, estimate)
        if inference == last:
            continue
        last = inference
        task = input_of(session.tasks, inputs.task_stamp, recorded.log_time)
        step, asked, answered = _what_changed(session, before, given, recorded.log_time)
        used = task.used_objects if task is not None else ()
        pairs = estimate.mapping.as_dict
        wrong = {s for s in used if not answers.is_right(s, pairs.get(s, ""))} if answers is not None else set()
        rows.append(
            AssistRow(
                num_assists=estimate.num_assists,
                step_index=step,
                asked=asked,
                answered=answered,
                pairs=estimate.mapping.pairs,
                confidence=estimate.confidence,
                confident=inputs.confident,
                ties=estimate.ties,
                winning=estimate.winning,
                best_guess=estimate.best_guess,
                obeying=estimate.obeying,
                doubted=doubt_text(estimate),
                correct=None if answers is None else answers.correct(estimate, used),
                wrong=frozenset(wrong),
            )
        )
        before = given
    return tuple(rows)


def doubt_text(estimate: MappingEstimate) -> str:
    """Which assist is doubted, and the probability that it is wrong; "" for none."""
    doubted = estimate.doubted
    return "" if doubted is None else f"doubts {doubted.source_id}→{doubted.target_id} ({estimate.doubt:.2f})"


def readings_text(row: AssistRow) -> str:
    """Both readings where they differ, one a line; "" where they agree or an older version named none."""
    if row.best_guess.pairs == row.obeying.pairs:
        return ""
    named = (("best guess", row.best_guess), ("as told", row.obeying))
    return "\n".join(f"{name} ({m.score:.2f}): " + " ".join(f"{s}→{t}" for s, t in m.pairs) for name, m in named)


def _what_changed(
    session: RecordedSession, before: Sequence[Assist], now: Sequence[Assist], log_time: int
) -> tuple[int, str, str]:
    """(step, question, answer) of the assist that ``now`` has more than ``before``."""
    new = [a for a in now if a not in before]
    if not new:
        gone = [a for a in before if a not in now]
        return -1, "", "; ".join(f"withdrawn: {a.source_id}→{a.target_id}" for a in gone)
    assist = new[-1]
    questions = [
        p.value.text
        for p in session.prompts
        if p.value.kind not in NO_QUESTION and p.value.step_index == assist.step_index and p.log_time <= log_time
    ]
    how = "handed" if assist.kind is AssistKind.HANDED else "pointed at"
    return assist.step_index, questions[-1] if questions else "", f"{how} {assist.target_id}"


def _asked_and_answered(row: AssistRow) -> str:
    if row.step_index < 0:
        return escape(row.answered) or "[dim]nothing yet[/]"
    return escape(f"{row.asked}\nstep {row.step_index + 1}: {row.answered}".lstrip())


def rich_table(rows: Sequence[AssistRow], title: str) -> Table:
    """The rows for a terminal of 80 columns or more; ``#`` is the number of assists in force."""
    table = Table(title=title, title_justify="left", header_style="bold", box=box.ROUNDED, show_lines=True)
    table.add_column("#", justify="right", no_wrap=True)
    table.add_column("asked and answered", max_width=28)
    table.add_column("mapping predicted")
    table.add_column("confidence", justify="right", no_wrap=True)
    table.add_column("feature", no_wrap=True)
    table.add_column("correct", no_wrap=True)
    for row in rows:
        pairs = [
            f"[red]{escape(s)}→{escape(t)}[/]" if s in row.wrong else f"{escape(s)}→{escape(t)}" for s, t in row.pairs
        ]
        confidence = f"[bold green]{row.confidence:.4f}[/]" if row.confident else f"{row.confidence:.4f}"
        table.add_row(
            str(row.num_assists),
            _asked_and_answered(row),
            "\n".join(filter(None, ("  ".join(pairs) or "none", escape(readings_text(row)), escape(row.doubted)))),
            confidence + (f"\n{row.ties} ties" if row.ties > 1 else ""),
            "\n".join(row.winning) or "–",
            {True: "[green]right[/]", False: "[red]wrong[/]", None: "unknown"}[row.correct],
        )
    return table


def _tool() -> int:
    arguments = bag_parser(__doc__ or "").parse_args()
    console = Console()
    _, session = read_session(arguments.bag, console)
    rows = assist_rows(session)
    facts = ", ".join(f"{k} {session.facts[k]}" for k in ("task", "participant", "seed") if session.facts.get(k))
    console.print(rich_table(rows, escape(f"session {session.name}" + (f" ({facts})" if facts else ""))))
    if not rows:
        console.print("[yellow]no estimate was made in this session[/]")
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when the bag cannot be used."""
    run_tool("table", _tool)
