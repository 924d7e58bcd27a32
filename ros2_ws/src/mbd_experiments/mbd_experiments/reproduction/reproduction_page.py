"""The page that sets paper and project side by side, with a remark on each difference."""

from __future__ import annotations

import os
import shutil
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

from mbd_model.folders import make_folder

from mbd_experiments.csv_table import markdown, read_csv
from mbd_experiments.reproduction import side_by_side
from mbd_experiments.reproduction.paper_figures import CASE_STUDIES
from mbd_experiments.reproduction.remarks import REMARKS
from mbd_experiments.reproduction.side_by_side import Results

WIDTH = 120  # characters of a line of documentation
HEAD = """# Paper and project, side by side

Written by `reproduce`: its tables are read from the CSV files it wrote, its pictures are drawn from them.

    ./mbd run mbd_experiments simulate_study out/simulated_study --seed 1  # run again to go on
    ./mbd run mbd_experiments reproduce --all --study DATA/hri17 --simulated out/simulated_study --out out/reproduction

Single experiments, on the public study folder (data/hri17 of TescaF/interactive_mapping), a simulated study, or any
folder of session bags:

    ./mbd run mbd_experiments experiment2 FOLDER --out out/experiment2        # tables 4 and 5, figure 9
    ./mbd run mbd_experiments experiment3 FOLDER --out out/experiment3        # figures 10 a-d, best thresholds
    ./mbd run mbd_experiments import_study DATA/hri17 out/hri17_bags          # the study's files as session bags

Paper: T. Fitzgerald, A. Goel, A. Thomaz, *Human-Guided Object Mapping for Task Transfer*, ACM THRI 2018. `mbd` is the
paper's rule, `evidence` what goes beyond it (docs/mapping.md). A simulated participant shows the task in the cell, is
seen by the camera, and answers what the dialogue asks; he errs as `simulated_participants/error_model.py` draws it
from Table 5: takes a wrong object, moves the stack, puts an object aside, answers in another order or twice. The
remarks are about the run shipped with the project: 15 of the 30 public sessions, and the simulated study of seed 1.
"""


class Page:
    """A Markdown page that is put together part by part; pictures are copied beside it.

    Args:
        path: of the page.
        images: folder for the pictures.
    """

    def __init__(self, path: Path, images: Path) -> None:
        self._path, self._images = path, images
        self._parts = [HEAD]

    def add(self, *parts: str) -> None:
        """Add paragraphs, tables or headings."""
        self._parts += [part.rstrip("\n") + "\n" for part in parts]

    def remark(self, *keys: str) -> None:
        """Add remarks on what differs."""
        self.add(*("> " + REMARKS[key].strip().replace("\n", "\n> ") for key in keys))

    def picture(self, source: Path, caption: str) -> None:
        """Copy a picture and show it, with a caption that states whether its data is real or simulated."""
        make_folder(self._images)
        copied = self._images / source.name
        if copied.resolve() != source.resolve():
            shutil.copyfile(source, copied)
        link = Path(os.path.relpath(copied.resolve(), self._path.resolve().parent)).as_posix()
        self.add(_wrapped(f"![{caption}]({link})"), _wrapped(f"*{caption}*"))

    def write(self) -> Path:
        """Write the page; returns its path."""
        make_folder(self._path.parent)
        self._path.write_text("\n".join(self._parts), encoding="utf-8")
        return self._path


def _wrapped(text: str) -> str:
    """In lines of a document's width; Markdown takes the break for a space."""
    return textwrap.fill(text, WIDTH, break_long_words=False, break_on_hyphens=False)


def add_experiment1(page: Page, folder: Path) -> None:
    """Experiment 1 from ``shares.csv`` and its pictures."""
    rows = read_csv(folder / "shares.csv")
    page.add("## Experiment 1: simulated problems (paper sec. 5)", "Share solved within k assists, mean over problems.")
    most = max(int(r["assists"]) for r in rows)
    shown: dict[tuple[str, str], dict[str, str]] = {}
    for r in rows:
        key = (r["size"], r["method"])
        row = shown.setdefault(key, {"objects": key[0], "method": key[1]} | {f"k = {k}": "" for k in range(most + 1)})
        row[f"k = {r['assists']}"] = f"{float(r['solved_within']):.2f}"
    page.add(markdown(list(shown.values())))
    page.remark("experiment1")
    for picture in sorted(folder.glob("solved_*.png")):
        size = picture.stem.split("_")[1]
        page.picture(picture, f"Experiment 1, {size} objects. Simulated data: random problems.")


def add_case_studies(page: Page, table: Path) -> None:
    """Both case studies from their CSV."""
    page.add("## Case studies (paper sec. 5.1)", "Simulated data: object tables of our own.")
    page.add(markdown([{"case": name, "paper": text} for name, text in CASE_STUDIES.items()]))
    page.add(markdown(read_csv(table)))
    page.remark("case_studies")


def add_user_study(page: Page, sources: Sequence[Results], pictures: Mapping[str, Sequence[tuple[Path, str]]]) -> None:
    """Experiments 2 and 3.

    Args:
        page: to add to.
        sources: real and simulated results, one or both.
        pictures: (file, caption) of "figure9" and "figure10".
    """
    page.add("## Experiment 2: the user study (paper sec. 6)", REMARKS["data"].strip())
    page.add("### Table 4: objects / steps / solutions", side_by_side.tasks_side_by_side(sources))
    page.remark("table4")
    page.add("### Table 5: consistent demonstrations / assists / both", side_by_side.consistency_side_by_side(sources))
    page.remark("table5", "readings", "consistent", "moved")
    page.add("### Figure 9: right within k assists (and how many times unguided transfer)")
    page.add(side_by_side.assists_side_by_side(sources))
    page.remark("figure9")
    for path, caption in pictures["figure9"]:
        page.picture(path, caption)
    page.add("Sessions right after exactly k assists:", side_by_side.exactly_side_by_side(sources))
    page.remark("hurt")
    page.add("## Experiment 3: when to stop asking (paper sec. 7)", side_by_side.thresholds_side_by_side(sources))
    page.remark("threshold")
    page.add(*(_wrapped(line) for line in side_by_side.compared_at_best(sources)))
    page.add(side_by_side.policies_side_by_side(sources))
    page.remark("autonomy")
    for path, caption in pictures["figure10"]:
        page.picture(path, caption)
