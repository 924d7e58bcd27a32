"""A session's nodes, as processes, live through messages and requests that make no sense."""

from __future__ import annotations

from pathlib import Path

from mbd_bringup.ros.hostile.hostile_trials import hostile_trial


def test_no_node_dies_of_what_it_is_sent(tmp_path: Path):
    # Without the cell, which needs a core for itself; the command sends to it too.
    result = hostile_trial(600, 1, tmp_path, leave_out=frozenset({"cell"}))
    assert sum(result.sent.values()) >= 600
    assert len(result.sent) > 60
    assert result.deaths == {}, result.last_words
    assert result.silent == ()
