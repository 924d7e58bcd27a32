"""The sessions of bags/ are small, complete, and compute again to what they hold."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest
from mbd_bag.ros.session_conversions import session_from_bag
from mbd_bag.storage.bag import Bag
from mbd_study.recompute.session_check import check_bag
from mbd_study.recompute.stages import RecomputeFrom
from mbd_study.tables.session_table import assist_rows
from rosbags.rosbag2 import Reader

BAGS = Path(__file__).resolve().parents[2] / "bags"
NAMES = ("assembly", "dish_sorting", "lunch_packing", "sorting", "stacking", "stacking_undo")
MEBIBYTE = 1024 * 1024


def test_there_are_six_and_they_are_small():
    assert tuple(sorted(p.name for p in BAGS.iterdir() if p.is_dir())) == NAMES
    sizes = [p.stat().st_size for p in BAGS.rglob("*") if p.is_file()]
    assert sum(sizes) < 20e6
    assert max(sizes) < 4 * MEBIBYTE


@pytest.mark.parametrize("name", NAMES)
def test_each_is_a_complete_session_that_other_readers_open_too(name: str):
    bag = Bag(BAGS / name)
    session = session_from_bag(bag)
    assert bag.problems == ()
    assert session.states[-1].value.phase.name == "DONE"
    assert assist_rows(session)[-1].correct is not None
    with Reader(BAGS / name) as reader:
        assert reader.message_count == bag.message_count == len(list(reader.messages()))


@pytest.mark.parametrize("stage", list(RecomputeFrom))
@pytest.mark.parametrize("name", NAMES)
def test_each_computes_again_to_what_it_holds(name: str, stage: RecomputeFrom):
    summary = check_bag(BAGS / name, stage)
    assert summary.agrees, summary
    assert summary.estimates >= 1


def test_the_wrong_assist_is_withdrawn_and_noted():
    session = session_from_bag(Bag(BAGS / "stacking_undo"))
    shorter = [(old.value, new.value) for old, new in pairwise(session.assists) if len(new.value) < len(old.value)]
    assert len(shorter) == 1
    assert shorter[0][0][-1] not in session.assists[-1].value
    assert [n.value for n in session.notes] == ["That was the wrong object; I take it back."]


def test_nothing_in_a_bag_names_a_machine():
    for name in NAMES:
        text = (BAGS / name / "metadata.yaml").read_text()
        assert "/root" not in text
        assert "/home" not in text
        assert "/tmp" not in text
