"""The statechart in the docs is the one of the code."""

from __future__ import annotations

from pathlib import Path

import pytest
from mbd_interaction.statechart import arrows, mermaid, updated
from mbd_interaction.transitions import TABLE
from mbd_model.errors import MbdError
from mbd_model.session import Phase

PAGE = Path(__file__).resolve().parents[2] / "docs" / "wizard.md"


def test_the_docs_show_the_present_statechart():
    page = PAGE.read_text(encoding="utf-8")
    assert updated(page) == page, "run: python -m mbd_interaction.statechart docs/wizard.md"


def test_every_phase_is_drawn_and_reached():
    assert all(phase.name in mermaid() for phase in Phase)
    assert {after for _, after in arrows()} == set(Phase)


def test_every_arrow_is_in_the_table():
    for (before, after), signals in arrows().items():
        assert all(after in TABLE[before, signal].leads_to for signal in signals)


def test_a_page_without_marks_is_refused():
    with pytest.raises(MbdError, match="lacks the marks"):
        updated("# A page")
