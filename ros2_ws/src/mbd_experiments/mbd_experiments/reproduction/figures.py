"""Figures 9 and 10, each drawn from its CSV file and nothing else."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import Any

from mbd_model.folders import make_folder

from mbd_experiments.csv_table import read_csv
from mbd_experiments.reproduction.captions import caption, origins_in
from mbd_experiments.user_study.study_facts import Origin
from mbd_experiments.user_study.thresholds import ALL_TASKS

COLORS = {"mbd": "#0b6e99", "evidence": "#c4530a"}
NAMES = {"mbd": "mbd (the paper's rule)", "evidence": "evidence"}
UNGUIDED, RELEARNING = "#7a7a7a", "#3c3c3c"
PAPER_THRESHOLD = 0.02


def draw_figure9(table: Path, out: Path) -> list[Path]:
    """A panel for each task: share right within k assists. One picture for each origin; returns them."""
    rows = read_csv(table)
    return [_figure9([r for r in rows if r["origin"] == o], o, out) for o in origins_in(rows)]


def _figure9(rows: list[dict[str, str]], origin: Origin, out: Path) -> Path:
    tasks = list(dict.fromkeys(r["task"] for r in rows))
    figure, grid = _axes(1, len(tasks), (max(3.6 * len(tasks), 5.0), 3.6))
    axes = grid[0]
    for axis, task in zip(axes, tasks, strict=True):
        of_task = [r for r in rows if r["task"] == task]
        strategies = list(dict.fromkeys(r["strategy"] for r in of_task))
        for strategy in strategies:
            curve = [r for r in of_task if r["strategy"] == strategy]
            x = [int(r["assists"]) for r in curve]
            axis.plot(x, [_share(r, "within") for r in curve], "o-", color=COLORS[strategy], label=NAMES[strategy])
            axis.axhline(
                _share(curve[0], "unguided"),
                color=COLORS[strategy],
                lw=1,
                ls=":",
                label=f"unguided, {strategy}",
            )
            if strategy == strategies[0]:
                axis.step(
                    x, [_share(r, "relearning") for r in curve], where="post", color=RELEARNING, ls="--",
                    label="relearning",
                )  # fmt: skip
        axis.set(
            title=f"{task.replace('_', ' ')} (n = {of_task[0]['sessions']})", xlabel="assists k", ylim=(-0.04, 1.06)
        )
        axis.xaxis.get_major_locator().set_params(integer=True)
    axes[0].set_ylabel("share right within k assists")
    axes[0].legend(fontsize=7, loc="center left")
    return _save(figure, caption("figure9", origin, rows), out / f"figure9_{origin}.png")


def draw_figure10(table: Path, out: Path) -> list[Path]:
    """Panels a to d, all tasks together. One picture for each origin; returns them."""
    rows = [r for r in read_csv(table) if r["task"] == ALL_TASKS]
    return [_figure10([r for r in rows if r["origin"] == o], o, out) for o in origins_in(rows)]


def _figure10(rows: list[dict[str, str]], origin: Origin, out: Path) -> Path:
    figure, axes = _axes(2, 2, (9.6, 7.4))
    (a, b), (c, d) = axes
    right = c.twinx()
    for strategy in dict.fromkeys(r["strategy"] for r in rows):
        color = COLORS[strategy]
        curve = [r for r in rows if r["strategy"] == strategy and r["policy"] == "confident"]
        x, share, assists, autonomy = (_column(curve, n) for n in ("threshold", "share", "assists", "autonomy"))
        a.plot(x, assists, color=color, label=NAMES[strategy])
        b.plot(assists, share, "o-", ms=3, color=color, label=NAMES[strategy])
        c.plot(x, share, color=color, label=f"right, {strategy}")
        right.plot(x, assists, color=color, ls=":", label=f"assists, {strategy}")
        d.plot(autonomy, share, "o-", ms=3, color=color, label=f"confident guided, {strategy}")
        unguided = next(r for r in rows if r["strategy"] == strategy and r["policy"] == "unguided")
        d.plot(1.0, float(unguided["share"]), "s", color=color, mfc="none", ms=9, label=f"unguided, {strategy}")
    d.plot(0.0, 1.0, "^", color=RELEARNING, ms=9, label="relearning")
    for axis in (a, c):
        # The paper's range is 0 to 0.25; a probability needs all of it.
        axis.set_xscale("symlog", linthresh=0.05)
        axis.axvline(PAPER_THRESHOLD, color=UNGUIDED, lw=0.8, ls="--")
        ticks = (0.0, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0)
        axis.set_xticks(ticks, [f"{t:g}" for t in ticks])
    a.set(title="a", xlabel="confidence threshold", ylabel="assists a task, mean")
    b.set(title="b", xlabel="assists a task, mean", ylabel="share of tasks right")
    c.set(title="c", xlabel="confidence threshold", ylabel="share of tasks right")
    right.set_ylabel("assists a task, mean (dotted)")
    d.set(title="d", xlabel="autonomy: share of steps done alone", ylabel="share of tasks right")
    for axis in (b, c, d):
        axis.set_ylim(-0.04, 1.06)
    for axis in (a, b, d):
        axis.legend(fontsize=7)
    return _save(figure, caption("figure10", origin, rows), out / f"figure10_{origin}.png")


def _axes(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    # Imported where something is drawn: tables need no matplotlib.
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(rows, columns, figsize=size, dpi=80, squeeze=False)
    for axis in axes.flat:
        axis.grid(alpha=0.25)
    return figure, axes


def _save(figure: Any, text: str, out: Path) -> Path:
    import matplotlib.pyplot as plt

    make_folder(out.parent)
    figure.text(0.5, 0.01, fill(text, 110), ha="center", va="bottom", fontsize=8)
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    # No software version in the file: the same table gives the same picture.
    figure.savefig(out, metadata={"Software": None})
    plt.close(figure)
    return out


def _share(row: dict[str, str], column: str) -> float:
    return int(row[column]) / int(row["sessions"])


def _column(rows: list[dict[str, str]], name: str) -> list[float]:
    return [float(r[name]) for r in rows]
