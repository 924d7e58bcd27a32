"""The analysis as a page of Markdown: what was compared, the tables, and what they can and cannot show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isnan
from typing import Any

from mbd_study.analysis.measured import MeasuredValues
from mbd_study.analysis.study_table import StudyTable

_READ = """## How to read this

- Each participant counts once: of several values of one in a condition the mean is taken. Intervals are of 95 %, tests
  two-sided.
- `p_holm` is raised for the number of measures (tests) or of pairs (pairs). A p that is not small shows no equality:
  the interval states which differences remain possible, and the last table which would have been missed.
- The test is chosen by the numbers and the design, which the table states; `other_p` is that of the other kind of test.
  Where both disagree, trust neither alone."""


def analysis_page(
    tables: Mapping[str, Sequence[Any]], measures: Sequence[MeasuredValues], table: StudyTable, *, by: str, block: str
) -> str:
    """The page.

    Args:
        tables: rows of descriptives, tests, pairs and sensitivity.
        measures: that were compared.
        table: they are of.
        by: column of the conditions.
        block: column of the blocks; "" for none.
    """
    people = len({v.participant for m in measures for v in m.values})
    words = f"{len(table.rows)} {'sessions' if table.exported else 'rows'} of {people} participants, compared by {by}"
    words += f", {block} as blocks" if block else ""
    if table.simulated:
        words += f". SIMULATED are {table.simulated} of {len(table.rows)} sessions: they say nothing about people"
    parts = ["# Analysis", words + ".", *table.left_out, "## Means"]
    means = [
        (r.measure, r.condition, f"{r.participants} ({r.values})", _figure(r.mean), _figure(r.sd),
         _interval(r.ci_low, r.ci_high) + f" {r.ci_by}", f"{_figure(r.median)} [{_figure(r.quartile_low)}, "
         f"{_figure(r.quartile_high)}]")
        for r in tables["descriptives"]
    ]  # fmt: skip
    parts.append(_table(("measure", by, "participants (values)", "mean", "sd", "95 % CI", "median [quartiles]"), means))
    tests = [
        (r.measure, r.test, r.statistic, _p(r.p), _p(r.p_holm), f"{_figure(r.effect_size)} {r.effect}".strip(),
         f"{r.other_test} {_p(r.other_p)}".strip())
        for r in tables["tests"]
    ]  # fmt: skip
    parts += ["## Tests", _table(("measure", "test", "statistic", "p", "p_holm", "effect size", "other test"), tests)]
    parts += [f"- {r.measure} ({r.design}): {r.why}." for r in tables["tests"]]
    pairs = [
        (r.measure, f"{r.one} - {r.other}", str(r.participants),
         f"{_figure(r.difference)} {_interval(r.ci_low, r.ci_high)}",
         f"{_figure(r.effect_size)} {r.effect}", r.test, _p(r.p), _p(r.p_holm))
        for r in tables["pairs"]
    ]  # fmt: skip
    head = ("measure", "pair", "participants", "difference [95 % CI]", "effect size", "test", "p", "p_holm")
    parts += ["## Pairs", _table(head, pairs), "## What the sample can show"]
    shown = [
        (r.measure, f"{r.one} - {r.other}", r.participants, _figure(r.least_effect), _figure(r.least_difference),
         f"{100 * r.power_small:.0f}, {100 * r.power_medium:.0f}, {100 * r.power_large:.0f} %",
         f"{r.needed_small}, {r.needed_medium}, {r.needed_large}")
        for r in tables["sensitivity"]
    ]  # fmt: skip
    needs = ("least effect found (80 %)", "in its unit", "power at d = 0.2, 0.5, 0.8", "participants these need")
    parts.append(_table(("measure", "pair", "participants", *needs), shown))
    parts += [f"- {r.measure}, {r.one} - {r.other}: {r.words}." for r in tables["sensitivity"]]
    parts.append(_READ)
    return "\n\n".join(_joined(parts))


def _joined(parts: Sequence[str]) -> list[str]:
    """Paragraphs, lines of one list together."""
    found: list[str] = []
    for part in parts:
        if found and part.startswith("- ") and found[-1].startswith("- "):
            found[-1] += "\n" + part
        else:
            found.append(part)
    return found


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    cells = [[cell.replace("|", "\\|") for cell in row] for row in (head, *rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(head))]
    lines = ["| " + " | ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) + " |" for row in cells]
    return "\n".join([lines[0], "|" + "|".join("-" * (w + 2) for w in widths) + "|", *lines[1:]])


def _figure(value: float | None) -> str:
    if value is None or isnan(value):
        return ""
    if abs(value) >= 1000:
        return f"{value:.0f}"
    return f"{value:.3g}"


def _p(value: float | None) -> str:
    if value is None:
        return ""
    return "< 0.001" if value < 0.001 else f"{value:.3f}"


def _interval(low: float | None, high: float | None) -> str:
    return "" if low is None or high is None else f"[{_figure(low)}, {_figure(high)}]"
