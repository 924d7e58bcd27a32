"""A measure by condition: each participant's value, joined where it met several, with mean and interval."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mbd_study.analysis.describing import condition_rows
from mbd_study.analysis.measured import MeasuredValues

SEED = 20170306  # of the points' places beside each other


def draw_conditions(measured: MeasuredValues, out: Path) -> None:
    """Draw the figure as PNG.

    Args:
        measured: of the conditions.
        out: of the file; not overwritten.
    """
    # Here, not above: half a second that no other command needs.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(1.6 + 1.1 * len(measured.conditions), 3.2), dpi=150, layout="constrained")
    axes = figure.add_subplot()
    places = np.arange(len(measured.conditions))
    aside = 0.1 * np.random.default_rng(SEED).uniform(-1, 1, len(measured.participants))
    for row, shift in zip(measured.means, aside, strict=True):
        axes.plot(places + shift, row, "o-", color="#9aa5b1", markersize=3.5, linewidth=0.8, zorder=1)
    for place, row in zip(places, condition_rows(measured), strict=True):
        if row.ci_low is not None and row.ci_high is not None:
            axes.plot([place, place], [row.ci_low, row.ci_high], color="#1f4e79", linewidth=2.5, zorder=2)
        axes.plot([place], [row.mean], "D", color="#1f4e79", markersize=6, zorder=3)
    axes.set_xticks(places, measured.conditions)
    axes.set_xlim(-0.5, len(places) - 0.5)
    axes.set_ylabel(measured.name.replace("_", " "))
    axes.set_title("mean, 95 % interval; grey: participants", fontsize=8)
    axes.spines[["top", "right"]].set_visible(False)
    FigureCanvasAgg(figure)
    with out.open("xb") as stream:
        figure.savefig(stream, format="png")
