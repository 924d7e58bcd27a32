"""The board on paper, at its true size."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from mbd_model.errors import MbdError

from mbd_robot.calibration.board.pattern import BoardPattern

MM_PER_INCH = 25.4
MARGIN = 10.0  # [mm] of white around it: markers are found by their border
SHARP = 300.0  # [1/inch] of a printed picture
PAPERS = {"A4": (297.0, 210.0), "A3": (420.0, 297.0), "A2": (594.0, 420.0), "A1": (841.0, 594.0)}
ENDINGS = (".pdf", ".png", ".svg")


def print_board(board: BoardPattern, file: Path) -> str:
    """Write the board at its true size, with a ruler of 100 mm to check the print by.

    Args:
        board: what to print.
        file: to write; its ending says what: pdf, svg, or png, which states its resolution.

    Returns:
        What to do with it, in words.

    Raises:
        MbdError: the file is there already, its ending is another, or it cannot be written.
    """
    if file.suffix.lower() not in ENDINGS:
        raise MbdError(f"{file} ends in '{file.suffix}'; expected {', '.join(ENDINGS)}")
    if file.exists():
        raise MbdError(f"{file} is there already, and nothing is overwritten; give another name")
    width, height = (side + 2 * MARGIN for side in board.size)
    paper = next((name for name, (w, h) in PAPERS.items() if width <= w and height <= h), "")
    page = PAPERS[paper] if paper else (width, height)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        _draw(board, file, page)
    except OSError as error:
        raise MbdError(f"{file} cannot be written: {error.strerror}; give another place") from error
    sheet = f"{paper}, landscape" if paper else f"a sheet of {width:.0f} x {height:.0f} mm"
    return (
        f"{file}: {board.described}, {board.size[0]:g} x {board.size[1]:g} mm. Print on {sheet}, at 100 % (no 'fit to "
        f"page'), and glue it on something flat and stiff. Measure it from edge to edge: it must be "
        f"{board.size[0]:g} mm; if not, give what you measured.\n"
        f"Give the board to calibrate as --board {board}"
    )


def _draw(board: BoardPattern, file: Path, page: tuple[float, float]) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib.collections import PatchCollection
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    figure = Figure(figsize=(page[0] / MM_PER_INCH, page[1] / MM_PER_INCH))
    w, h = board.size
    left, bottom = (page[0] - w) / 2, (page[1] - h) / 2
    sheet = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    sheet.set_xlim(0, page[0])
    sheet.set_ylim(0, page[1])
    sheet.set_axis_off()
    cells = [Rectangle((left + x, bottom + h - y - side), side, side) for x, y, side in board.cells()]
    sheet.add_collection(PatchCollection(cells, facecolor="black", edgecolor="none", antialiased=False))
    sheet.plot([left, left + 100.0], [bottom / 2] * 2, color="black", linewidth=0.5, marker="|", markersize=4)
    sheet.text(left + 102.0, bottom / 2, f"100 mm   {board}", fontsize=6, va="center")
    figure.savefig(file, dpi=SHARP)


def board_picture(board: BoardPattern, pixels_per_mm: float = 4.0) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """(H, W, 3) uint8 of the board alone, for something that shows it as a texture."""
    return np.asarray(cv2.cvtColor(board.raster(pixels_per_mm), cv2.COLOR_GRAY2RGB), dtype=np.uint8)
