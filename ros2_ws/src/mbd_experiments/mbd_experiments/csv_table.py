"""Tables as CSV files: written first, and everything that is shown is drawn from the file."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_model.folders import make_folder

CsvCell = str | int | float
CsvRow = Mapping[str, CsvCell]


def write_csv(path: Path, rows: Sequence[CsvRow]) -> Path:
    """Write rows that all have the same columns; numbers with up to 6 digits. Returns the path.

    Raises:
        BagError: there is no row, or one has other columns.
    """
    if not rows:
        raise BagError(f"there is nothing to write to {path.name}")
    columns = list(rows[0])
    if any(list(row) != columns for row in rows):
        raise BagError(f"rows of {path.name} differ in their columns; expected {columns}")
    make_folder(path.parent)
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([_text(row[c]) for c in columns] for row in rows)
    return path


def read_csv(path: Path) -> list[dict[str, str]]:
    """The rows of a table as this project or a spreadsheet writes it: with or without a byte-order mark, any line ends.

    Raises:
        BagError: there is no such file, its columns are separated by something else than commas, or it is no UTF-8.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            rows = csv.DictReader(stream)
            names = list(rows.fieldnames or ())
            if len(names) == 1 and (sign := next((s for s in (";", "\t") if s in names[0]), "")):
                kind = "tabs" if sign == "\t" else "semicolons"
                raise BagError(f"{path}:1: the columns are separated by {kind}; save the table as CSV with commas")
            return list(rows)
    except OSError as error:
        raise BagError(f"cannot read {path}: {error.strerror}; run the experiment that writes it") from error
    except UnicodeDecodeError as error:
        raise BagError(f"{path} is no table of text ({error}); save it as CSV (UTF-8)") from error
    except csv.Error as error:
        raise BagError(f"{path} is no table ({error}); save it as CSV (UTF-8)") from error


def markdown(rows: Sequence[Mapping[str, str]], names: Mapping[str, str] | None = None) -> str:
    """A Markdown table.

    Args:
        rows: of `read_csv`.
        names: heading by column, of the columns to show in that order; None: all under their own names.
    """
    names = names or {c: c.replace("_", " ") for c in (rows[0] if rows else {})}
    lines = ["| " + " | ".join(names.values()) + " |", "|" + "---|" * len(names)]
    lines += ["| " + " | ".join(row.get(c, "") for c in names) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def _text(value: CsvCell) -> str:
    if isinstance(value, float):
        return f"{value:.6f}".rstrip("0").rstrip(".")
    return str(value)
