"""Rows that set the paper's numbers beside ours, read from the experiments' CSV files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mbd_experiments.csv_table import markdown, read_csv
from mbd_experiments.reproduction.paper_figures import (
    ALL_SESSIONS_AT_BEST,
    BEST_SHARE,
    BEST_THRESHOLD,
    PARTICIPANTS,
    TASKS,
)

Rows = Sequence[dict[str, str]]


@dataclass(frozen=True)
class Results:
    """One source's tables.

    Attributes:
        title: heading of its columns.
        folder: of experiments 2 and 3 run on it.
    """

    title: str
    folder: Path

    @property
    def short_title(self) -> str:
        """Without the number of sessions, where each cell says it."""
        return self.title.partition(" (")[0]

    def table(self, name: str) -> Rows:
        """The rows of one of its CSV files."""
        return read_csv(self.folder / f"{name}.csv")


def tasks_side_by_side(sources: Sequence[Results]) -> str:
    """Table 4: objects, steps, solutions."""
    rows = []
    for task, paper in TASKS.items():
        row = {"task": _name(task), "paper": f"{paper.objects} / {paper.steps} / {paper.solutions}"}
        for source in sources:
            own = _only(source.table("table4"), task=task)
            row[source.title] = " ; ".join(f"{r['source_objects']} / {r['steps']} / {r['solutions']}" for r in own)
        rows.append(row)
    return markdown(rows)


def consistency_side_by_side(sources: Sequence[Results]) -> str:
    """Table 5: consistent demonstrations / assists / both."""
    rows = []
    for task, paper in TASKS.items():
        counts = f"{paper.demonstrations} / {paper.assists} / {paper.both} of {PARTICIPANTS}"
        rows.append({"task": _name(task), "data": "paper", "demonstrations / assists / both": counts})
        for source in sources:
            own = _only(source.table("table5"), task=task)
            for r in own[:1]:
                counts = " / ".join(
                    r[k] for k in ("consistent_demonstrations", "consistent_assists", "both_consistent")
                )
                mapped = {f"mapped, {o['strategy']}": f"{o['mapped_of_both']} of {o['both_consistent']}" for o in own}
                row = {"task": _name(task), "data": source.title}
                rows.append({**row, "demonstrations / assists / both": f"{counts} of {r['sessions']}", **mapped})
    return markdown(_filled(rows))


def assists_side_by_side(sources: Sequence[Results]) -> str:
    """Figure 9: right within the paper's number of assists, and over unguided transfer."""
    rows = []
    for task, paper in TASKS.items():
        right, count = paper.within
        row = {"task": f"{_name(task)}, within {count}", "paper": f"{right} of {PARTICIPANTS} ({paper.gain:g} ×)"}
        for source in sources:
            for r in _only(source.table("figure9"), task=task, assists=str(count)):
                gain = f"{int(r['within']) / int(r['unguided']):.2g} ×" if int(r["unguided"]) else "from none"
                row[f"{source.short_title}, {r['strategy']}"] = f"{r['within']} of {r['sessions']} ({gain})"
        rows.append(row)
    return markdown(rows)


def exactly_side_by_side(sources: Sequence[Results], most: int = 4) -> str:
    """Right after exactly 0, 1, ... and after all assists: what more of them do."""
    rows = []
    for source in sources:
        table = source.table("figure9")
        for task, strategy in dict.fromkeys((r["task"], r["strategy"]) for r in table):
            own = _only(table, task=task, strategy=strategy)
            row = {"data": source.title, "task": _name(task), "strategy": strategy}
            row |= {f"k = {r['assists']}": r["correct"] for r in own[: most + 1]}
            rows.append({**row, "all given": own[-1]["correct"], "of": own[0]["sessions"]})
    return markdown(rows)


def thresholds_side_by_side(sources: Sequence[Results]) -> str:
    """Figure 10: the best threshold, and what it gets right at which cost."""
    paper = {
        "data": "paper",
        "strategy": "mbd",
        "threshold": f"{BEST_THRESHOLD:g}",
        "tasks right": f"{100 * BEST_SHARE:.1f} %",
        "assists, mean": "0 or 1",
        "autonomy": "",
    }
    reading = {**paper, "data": "its 30 sessions, read independently", "threshold": "0.015"}
    reading |= {"tasks right": ALL_SESSIONS_AT_BEST.split(" with")[0], "assists, mean": "0.53"}
    rows = [paper, reading]
    for source in sources:
        for r in _only(source.table("best_thresholds"), task="all"):
            rows.append(_threshold_row(source.title, r["strategy"], f"{r['threshold']} to {r['also_best_to']}", r))
        for r in _only(source.table("figure10"), task="all", strategy="mbd", threshold=f"{BEST_THRESHOLD:g}"):
            rows.append(_threshold_row(f"{source.title}, the paper's threshold", "mbd", r["threshold"], r))
    return markdown(rows)


def compared_at_best(sources: Sequence[Results]) -> list[str]:
    """A sentence for each source: which strategy gets how many more right at its best threshold, asking for what."""
    lines = []
    for source in sources:
        best = {r["strategy"]: r for r in _only(source.table("best_thresholds"), task="all")}
        if not {"mbd", "evidence"} <= set(best):
            continue
        more = int(best["evidence"]["correct"]) - int(best["mbd"]["correct"])
        asked = float(best["evidence"]["assists"]) - float(best["mbd"]["assists"])
        right = "as many right as" if not more else f"{abs(more)} {'more' if more > 0 else 'fewer'} right than"
        help_ = f"{abs(asked):.2f} assists {'more' if asked > 0 else 'fewer'}"
        lines.append(
            f"{source.title}: at their best thresholds `evidence` gets {right} `mbd`, with {help_} on average."
        )
    return lines


def policies_side_by_side(sources: Sequence[Results]) -> str:
    """Figure 10 d: unguided, relearning, confident guided."""
    rows = []
    for source in sources:
        best = {r["strategy"]: r for r in _only(source.table("best_thresholds"), task="all")}
        table = _only(source.table("figure10"), task="all")
        for strategy, guided in best.items():
            others = [r for r in _only(table, strategy=strategy) if r["policy"] != "confident"]
            for r in (*others, guided):
                name = "confident guided" if r["policy"] == "confident" else r["policy"]
                right = f"{r['correct']} of {r['sessions']}"
                autonomy = f"{100 * float(r['autonomy']):.0f} %"
                row = {"data": source.title, "strategy": strategy, "policy": name, "tasks right": right}
                rows.append({**row, "autonomy": autonomy})
    return markdown(rows)


def _threshold_row(data: str, strategy: str, threshold: str, row: dict[str, str]) -> dict[str, str]:
    return {
        "data": data,
        "strategy": strategy,
        "threshold": threshold,
        "tasks right": f"{row['correct']} of {row['sessions']} ({100 * float(row['share']):.1f} %)",
        "assists, mean": f"{float(row['assists']):.2f}",
        "autonomy": f"{100 * float(row['autonomy']):.0f} %",
    }


def _filled(rows: Sequence[dict[str, str]]) -> list[dict[str, str]]:
    """The rows with every column of any of them, empty where they have none."""
    columns = list(dict.fromkeys(column for row in rows for column in row))
    return [{column: row.get(column, "") for column in columns} for row in rows]


def _only(rows: Rows, **wanted: str) -> list[dict[str, str]]:
    return [r for r in rows if all(r[key] == value for key, value in wanted.items())]


def _name(task: str) -> str:
    return task.replace("_", " ")
