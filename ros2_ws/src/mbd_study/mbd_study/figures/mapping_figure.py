"""A figure of a mapping: source and target scene side by side, an arrow for each pair."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mbd_bag.session.scene_images import Picture
from mbd_model.camera.view import CameraView
from mbd_model.colors import ASSISTED, PREDICTED, WRONG
from mbd_model.geometry.boxes import box_corners
from mbd_model.objects import Role, Scene, SceneObject
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

INK, PAPER = "#22262b", "#fbfaf8"
_ASPECT = 1.25  # width of a panel by its height
Points = NDArray[np.float64]


@dataclass(frozen=True)
class ScenePanel:
    """One scene as it is drawn.

    Attributes:
        title: above it.
        scene: its objects.
        image: what the camera saw; None: a view from above is drawn instead.
        camera: through which it was seen; None with ``image``.
    """

    title: str
    scene: Scene
    image: Picture | None = None
    camera: CameraView | None = None

    def place(self, points: Points) -> Points:
        """(n, 2) drawing coordinates (right, down) of (n, 3) points [m, base frame]: pixels, or metres from above."""
        if self.camera is not None:
            return self.camera.project(points)
        return np.stack([-points[:, 1], -points[:, 0]], axis=1)

    def outline(self, thing: SceneObject) -> Points:
        """(n, 2) convex outline of the object's complete box, in drawing coordinates."""
        corners = self.place(box_corners(thing))
        outline: Points = corners[ConvexHull(corners).vertices]
        return outline

    def centre(self, thing: SceneObject) -> Points:
        """(2,) drawing coordinates of the object's middle."""
        middle: Points = self.place(np.array([thing.centroid]))[0]
        return middle


@dataclass(frozen=True)
class MappingArrow:
    """One pair of the mapping as it is drawn: its ids, whether an assist gave it, whether it is known to be wrong."""

    source_id: str
    target_id: str
    assisted: bool
    wrong: bool = False

    @property
    def color(self) -> str:
        """Assisted by the teacher, predicted, or predicted wrongly."""
        return ASSISTED if self.assisted else WRONG if self.wrong else PREDICTED


def draw_mapping(
    panels: tuple[ScenePanel, ScenePanel], arrows: Sequence[MappingArrow], title: str, subtitle: str, out: Path
) -> None:
    """Draw both scenes with the mapping between them.

    Args:
        panels: source and target.
        arrows: the mapping.
        title: above both.
        subtitle: below the title.
        out: picture file to write (PNG); its folder is made when missing.
    """
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(13.0, 6.4), dpi=130, facecolor=PAPER)
    figure.subplots_adjust(left=0.015, right=0.985, top=0.83, bottom=0.09, wspace=0.03)
    spans = [_crop(panel) for panel in panels]
    # The same scale in both, so that sizes can be compared by eye.
    half = np.max([np.ptp(s, axis=0) for s in spans], axis=0) / 2
    half = np.maximum(half, (_ASPECT * half[1], half[0] / _ASPECT))
    for axis, panel, span in zip(axes, panels, spans, strict=True):
        _draw_panel(axis, panel, span.mean(axis=0), half)
    for arrow in sorted(arrows, key=lambda a: a.assisted):
        _draw_arrow(figure, axes, panels, arrow)
    by_id = ({a.source_id: a for a in arrows}, {a.target_id: a for a in arrows})
    for axis, panel, arrow_of in zip(axes, panels, by_id, strict=True):
        for thing in panel.scene.objects:
            _draw_label(figure, axis, panel, thing, arrow_of.get(thing.object_id))
    figure.text(0.02, 0.945, title, fontsize=19, fontweight="bold", color=INK, va="center")
    figure.text(0.02, 0.893, subtitle, fontsize=12, color="#5b6168", va="center")
    _draw_legend(figure, arrows)
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out, facecolor=PAPER)
    plt.close(figure)


def _crop(panel: ScenePanel) -> Points:
    """(2, 2) least and greatest drawing coordinates to show: every object with a margin."""
    corners = np.concatenate([panel.outline(o) for o in panel.scene.objects] or [np.zeros((1, 2))])
    low, high = np.nanmin(corners, axis=0), np.nanmax(corners, axis=0)
    margin = 0.13 * max(high - low) + 1e-3
    return np.array([low - margin, high + margin])


def _draw_panel(axis: Any, panel: ScenePanel, middle: Points, half: Points) -> None:
    from matplotlib.patches import Polygon
    from matplotlib.patheffects import Stroke

    axis.set_facecolor("#e9e4da")
    if panel.image is not None:
        axis.imshow(panel.image, interpolation="lanczos", aspect="equal")
    axis.set(xlim=(middle[0] - half[0], middle[0] + half[0]), ylim=(middle[1] + half[1], middle[1] - half[1]))
    axis.set(xticks=[], yticks=[], aspect="equal")
    for spine in axis.spines.values():
        spine.set_edgecolor("#c9c4ba")
    axis.set_title(panel.title, fontsize=13, color=INK, loc="left", pad=6)
    for thing in panel.scene.objects:
        outline = panel.outline(thing)
        face = _color(thing) if panel.image is None else (0.0, 0.0, 0.0, 0.0)
        halo = Stroke(linewidth=3.4, foreground=(0.0, 0.0, 0.0, 0.55))
        patch = Polygon(outline, closed=True, facecolor=face, edgecolor="white", linewidth=1.6, joinstyle="round")
        patch.set_path_effects([halo, Stroke()])
        axis.add_patch(patch)


def _draw_label(figure: Any, axis: Any, panel: ScenePanel, thing: SceneObject, arrow: MappingArrow | None) -> None:
    """The object's id below its box, over every arrow; a target states whose part it plays."""
    from matplotlib.text import Annotation

    outline = panel.outline(thing)
    text = thing.object_id
    if arrow is not None and arrow.target_id == thing.object_id and panel.scene.role is Role.TARGET:
        text = f"{thing.object_id}  as  {arrow.source_id}"
    edge = "none" if arrow is None else arrow.color
    label = Annotation(
        text,
        (float(np.ptp(outline[:, 0]) / 2 + outline[:, 0].min()), float(outline[:, 1].max())),
        xycoords=axis.transData,
        xytext=(0, -5),
        textcoords="offset points",
        ha="center",
        va="top",
        fontsize=10,
        fontweight="bold",
        color="white",
        zorder=9,
        bbox={"boxstyle": "round,pad=0.28", "facecolor": (0.1, 0.11, 0.13, 0.85), "edgecolor": edge, "linewidth": 1.8},
    )
    figure.add_artist(label)


def _color(thing: SceneObject) -> tuple[float, float, float]:
    if thing.hue is None:
        return (0.62, 0.62, 0.62)
    return colorsys.hsv_to_rgb(thing.hue / 360.0, 0.65, 0.85)


def _draw_arrow(figure: Any, axes: Any, panels: tuple[ScenePanel, ScenePanel], arrow: MappingArrow) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import ConnectionPatch
    from matplotlib.patheffects import Normal, Stroke

    start = panels[0].centre(panels[0].scene[arrow.source_id])
    end = panels[1].centre(panels[1].scene[arrow.target_id])
    patch = ConnectionPatch(
        tuple(start),
        tuple(end),
        "data",
        "data",
        axesA=axes[0],
        axesB=axes[1],
        arrowstyle="-|>,head_length=0.55,head_width=0.28",
        connectionstyle="arc3,rad=-0.10",
        mutation_scale=17,
        shrinkA=6,
        shrinkB=7,
        linewidth=2.6,
        color=arrow.color,
        linestyle=(0, (4, 2)) if arrow.wrong else "solid",
        zorder=5,
    )
    patch.set_path_effects([Stroke(linewidth=5.2, foreground=(1.0, 1.0, 1.0, 0.85)), Normal()])
    figure.add_artist(patch)
    dot = Line2D([start[0]], [start[1]], marker="o", markersize=7.5, color=arrow.color, markeredgecolor="white")
    dot.set(transform=axes[0].transData, zorder=7, markeredgewidth=1.5)
    figure.add_artist(dot)


def _draw_legend(figure: Any, arrows: Sequence[MappingArrow]) -> None:
    from matplotlib.lines import Line2D

    kinds = {ASSISTED: "assisted by the teacher", PREDICTED: "predicted", WRONG: "predicted, but wrong"}
    shown = [color for color in kinds if any(a.color == color for a in arrows)]
    counts = [sum(a.color == color for a in arrows) for color in shown]
    handles = [Line2D([], [], color=color, linewidth=3.5) for color in shown]
    labels = [f"{kinds[color]} ({count})" for color, count in zip(shown, counts, strict=True)]
    if shown:
        figure.legend(
            handles, labels, loc="lower left", bbox_to_anchor=(0.012, 0.008), ncols=3, frameon=False, fontsize=12
        )
