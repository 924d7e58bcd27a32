"""Figures 4-6 of the paper, one for each number of objects, drawn from the CSV alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mbd_experiments.simulated_problems.experiment1_tables import Share

PAPER_FIGURE = {5: "Figure 4", 6: "Figure 5", 7: "Figure 6"}
STYLE = {"evidence": ("C0", "o-"), "mbd": ("C1", "s-"), "pruning": ("0.45", "^--"), "random": ("0.7", "v:")}


def draw(shares: Sequence[Share], size: int, path: Path) -> None:
    """Share solved after k assists or fewer, mean and one standard deviation over problems, into an image file."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.0, 4.0), layout="constrained")
    for method, (color, style) in STYLE.items():
        rows = sorted((s for s in shares if s.size == size and s.method == method), key=lambda s: s.assists)
        if rows:
            axes.errorbar(
                [row.assists for row in rows],
                [row.solved_within for row in rows],
                yerr=[row.spread for row in rows] if rows[0].spread or method in ("evidence", "mbd") else None,
                fmt=style,
                color=color,
                capsize=3,
                label=method,
            )
    axes.set_xlabel("assists given (k)")
    axes.set_ylabel("share solved after ≤ k assists")
    axes.set_ylim(0.0, 1.05)
    title = PAPER_FIGURE.get(size, "larger run")
    axes.set_title(f"{title}: experiment 1, {size} objects; mean ± one std over problems", fontsize="medium")
    axes.legend()
    figure.savefig(path, dpi=120, metadata={"Software": None})
    plt.close(figure)
