"""Both strategies are computed on the same recorded inputs and shown side by side."""

from __future__ import annotations

from pathlib import Path

import pytest
from mbd_bag.session.command_line import open_session
from mbd_mapping.inference import STRATEGIES
from mbd_study.recompute.both_strategies import strategies_table, strategy_rows
from rich.console import Console

BAGS = Path(__file__).parents[2] / "bags"


@pytest.mark.parametrize("name", ["sorting", "assembly"])
def test_of_every_list_of_assists_each_strategy_has_its_estimate(name: str):
    _, session = open_session(BAGS / name)
    rows = strategy_rows(session)
    assert [row.num_assists for row in rows] == list(range(len(session.assists[-1].value) + 1))
    own = session.estimates[-1][0].value
    assert rows[-1].estimates[own.strategy].mapping == own.mapping
    assert all(set(row.estimates) == set(STRATEGIES) == set(row.right) for row in rows)


def test_the_table_shows_both_and_whether_each_is_right():
    console = Console(width=110)
    rows = strategy_rows(open_session(BAGS / "sorting")[1])
    with console.capture() as capture:
        console.print(strategies_table(rows))
    shown = capture.get()
    for row in rows:
        for strategy, estimate in row.estimates.items():
            goes = "goes on alone" if estimate.confident else "asks on"
            right = "right" if row.right[strategy] else "wrong"
            assert f"{estimate.confidence:.3f}, {goes}, {right}" in shown
    assert all(strategy in shown for strategy in STRATEGIES)
