"""The table shows a session assist by assist, and knows right from wrong where the cell's truth is recorded."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_model.estimate import Mapping
from mbd_model.objects import Role
from mbd_study.synthetic import SyntheticSession, scene, session, truth
from mbd_study.tables import info, session_table
from mbd_study.tables.correctness import answers_of, match_names
from mbd_study.tables.session_table import assist_rows


def test_each_row_states_what_was_asked_and_answered(made: SyntheticSession):
    rows = assist_rows(made.recorded)
    assert [r.num_assists for r in rows] == [0, 1, 2, 3]
    assert [r.step_index for r in rows] == [-1, 0, 1, 2]
    assert [r.asked for r in rows] == ["", "What do I use now?", "Where do I go next?", "What do I use now?"]
    assert [r.answered.split()[0] for r in rows[1:]] == ["handed", "pointed", "handed"]
    given_ids = [a.target_id for a in made.recorded.assists[-1].value]
    assert [r.answered.split()[-1] for r in rows[1:]] == given_ids


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_row_is_right_exactly_when_every_object_the_task_uses_is_mapped_rightly(seed: int):
    made = session("any", np.random.default_rng(seed), num_assists=2)
    for row in assist_rows(made.recorded):
        pairs = dict(row.pairs)
        wrong = {s for s, targets in made.solution.items() if pairs[s] not in targets}
        assert row.wrong == wrong
        assert row.correct is (not wrong)


def test_without_truth_nobody_knows(made: SyntheticSession):
    rows = assist_rows(replace(made.recorded, truths=()))
    assert all(r.correct is None and not r.wrong for r in rows)


def test_an_estimate_repeated_after_a_restart_makes_no_second_row(made: SyntheticSession):
    first, inputs = made.recorded.estimates[0]
    again = (replace(first, log_time=first.log_time + 10), inputs)
    repeated = (made.recorded.estimates[0], again, *made.recorded.estimates[1:])
    assert assist_rows(replace(made.recorded, estimates=repeated)) == assist_rows(made.recorded)


def test_an_empty_list_of_assists_is_no_news_after_none(made: SyntheticSession):
    """The mapping answers once before interaction has output anything and once after its empty list."""
    first, inputs = made.recorded.estimates[0]
    before = (replace(first, log_time=first.log_time - 10), replace(inputs, assists_stamp=0))
    both = replace(made.recorded, estimates=(before, *made.recorded.estimates))
    assert assist_rows(both) == assist_rows(made.recorded)


def test_an_undone_assist_is_assisted_as_withdrawn(made: SyntheticSession):
    recorded = made.recorded
    undone = replace(recorded.assists[1], stamp=50_000_000_000, log_time=50_000_000_000)
    estimate, inputs = recorded.estimates[1]
    again = (replace(estimate, log_time=50_100_000_000), replace(inputs, assists_stamp=50_000_000_000))
    longer = replace(recorded, assists=(*recorded.assists, undone), estimates=(*recorded.estimates, again))
    assert "withdrawn" in assist_rows(longer)[-1].answered


@given(seed=st.integers(0, 2**32 - 1), noise=st.floats(0.0, 0.03))
def test_perceived_objects_are_known_again_by_where_they_stand(seed: int, noise: float):
    rng = np.random.default_rng(seed)
    seen = scene(Role.SOURCE, 1.0, rng)
    real = truth(seen, {})
    moved = [
        replace(o, centroid=(o.centroid[0] + noise * rng.uniform(-1, 1), o.centroid[1], o.centroid[2]))
        for o in real.objects
    ]
    shuffled = [moved[k] for k in rng.permutation(len(moved))]
    assert match_names(seen, shuffled) == {o.object_id: f"true_{o.object_id}" for o in seen.objects}


def test_an_object_where_none_really_stands_has_no_name():
    seen = scene(Role.SOURCE, 1.0, np.random.default_rng(0))
    real = truth(seen, {})
    assert set(match_names(seen, real.objects[1:])) == set(seen.ids[1:])
    assert match_names(seen, ()) == {}


def test_no_mapping_is_no_right_mapping(made: SyntheticSession):
    answers = answers_of(made.recorded)
    assert answers is not None
    nothing = replace(made.recorded.estimates[0][0].value, mapping=Mapping(()))
    assert not answers.correct(nothing, made.recorded.tasks[0].value.used_objects)


@pytest.mark.parametrize("tool", [info, session_table], ids=lambda t: t.__name__)
def test_the_tools_show_a_session(
    tool: object, made_bag: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("sys.argv", ["tool", str(made_bag)])
    with pytest.raises(SystemExit) as ended:
        tool.main()
    assert ended.value.code == 0
    output = capsys.readouterr().out
    assert "made" in output
    assert "right" in output
