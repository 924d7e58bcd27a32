"""The paper's case studies (sec. 5.1)."""

from __future__ import annotations

import pytest
from mbd_experiments.simulated_problems.case_studies import assembly, case_studies, dish_sorting, predictions
from mbd_experiments.simulated_problems.case_studies_tool import main
from mbd_mapping.inference import STRATEGIES


def test_dish_sorting_gives_8_predictions_all_correct_after_one_assist() -> None:
    """Seven dishes sorted by what they afford: one assist leaves 2! 2! 2! mappings, and each is right."""
    after_one = predictions(dish_sorting(), "mbd")[1]
    assert (after_one.predictions, after_one.correct) == (8, 8)


def test_assembly_is_correct_after_3_assists() -> None:
    """Six blocks by hue and relative size: wrong before, right from the third assist on."""
    right = [line.predictions == line.correct == 1 for line in predictions(assembly(), "mbd")]
    assert right == [False, False, False, True, True, True, True]


def test_evidence_needs_no_assist_for_assembly() -> None:
    """What takes the rule three assists takes "evidence" none."""
    right = [line.predictions == line.correct == 1 for line in predictions(assembly(), "evidence")]
    assert right == [True, True, True, True, True, True, True]


@pytest.mark.parametrize("strategy", sorted(STRATEGIES))
def test_all_assists_solve_both(strategy: str) -> None:
    """With every object assisted the mapping is right."""
    for study in case_studies():
        last = predictions(study, strategy)[-1]
        assert last.predictions == last.correct == 1


def test_the_tool_prints_a_table_each(capsys: pytest.CaptureFixture[str]) -> None:
    """Both studies by both strategies."""
    assert main([]) == 0
    printed = capsys.readouterr().out
    assert printed.count("dish sorting") == printed.count("assembly") == len(STRATEGIES)
