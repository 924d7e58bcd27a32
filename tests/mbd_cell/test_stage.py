"""The cell follows a session: the right set on the table, the teacher's words at the right time."""

from __future__ import annotations

import pytest
from mbd_cell.arm.hand import GripperCommand
from mbd_cell.cell import TUCKED, Cell
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_cell.stage import Stage
from mbd_cell.teacher.script import Word
from mbd_model.objects import Role
from mbd_model.session import Phase
from shipped_scenes import scenes_of


def stage(teaches: bool = True) -> Stage:
    return Stage(Cell(scenes_of("assembly"), 4, CELL_CAMERA), teaches)


def words_within(stage: Stage, seconds: float) -> list[Word]:
    """What is spoken in that time, stopping where the clock stands still."""
    words = []
    for _ in range(round(seconds * 100)):
        passed = stage.tick()
        words += stage.take_words()
        if not passed:
            break
    return words


@pytest.mark.parametrize("phase", [Phase.OBSERVE_SOURCE, Phase.TUCK_AND_CLEAR])
def test_the_table_is_called_ready_when_the_set_is_laid_and_the_arm_tucked(phase: Phase) -> None:
    s = stage()
    s.enter(phase)
    assert words_within(s, 6.0) == [Word.READY]
    assert s.cell.role is (Role.SOURCE if phase is Phase.OBSERVE_SOURCE else Role.TARGET)
    assert s.cell.simulation.arm_joints == pytest.approx(TUCKED, abs=0.02)


def test_the_teacher_begins_in_the_demonstration_and_moves_only_once_it_is_recorded() -> None:
    s = stage()
    s.enter(Phase.DEMONSTRATE)
    assert words_within(s, 1.0) == [Word.DEMONSTRATION_BEGINS]
    before = s.cell.time_ns
    assert words_within(s, 1.0) == []
    assert s.cell.time_ns == before
    assert s.begin()
    assert words_within(s, 15.0) == [Word.CLOSE]
    assert s.unanswered is Word.CLOSE
    assert not s.gripper(GripperCommand.OPEN)
    assert s.gripper(GripperCommand.CLOSE)
    assert s.unanswered is None


def test_the_same_phase_received_again_changes_nothing() -> None:
    s = stage()
    s.enter(Phase.DEMONSTRATE)
    words_within(s, 1.0)
    s.begin()
    words_within(s, 2.0)
    s.enter(Phase.DEMONSTRATE)
    assert words_within(s, 15.0) == [Word.CLOSE]


def test_a_demonstration_asked_for_again_starts_on_a_table_laid_afresh() -> None:
    s = stage()
    s.enter(Phase.DEMONSTRATE)
    words_within(s, 1.0)
    s.begin()
    words_within(s, 15.0)
    laid = s.cell.generation
    s.enter(Phase.DEMONSTRATE, again=True)
    assert s.cell.generation == laid + 1
    assert s.cell.holding is None
    assert words_within(s, 1.0) == [Word.DEMONSTRATION_BEGINS]


@pytest.mark.parametrize("phase", [Phase.OBSERVE_TARGET, Phase.ASSIST, Phase.EXECUTE])
def test_a_cell_that_comes_back_late_lays_the_target_set(phase: Phase) -> None:
    s = stage()
    s.enter(phase)
    assert s.cell.role is Role.TARGET


def test_going_back_to_the_source_lays_it_again() -> None:
    s = stage()
    s.enter(Phase.OBSERVE_TARGET)
    s.enter(Phase.OBSERVE_SOURCE)
    assert words_within(s, 6.0) == [Word.READY]
    assert s.cell.role is Role.SOURCE


def test_without_a_scripted_teacher_nobody_demonstrates() -> None:
    s = stage(teaches=False)
    s.enter(Phase.DEMONSTRATE)
    assert words_within(s, 2.0) == []
    assert not s.cell.busy


def test_an_aborted_session_stops_the_arm() -> None:
    s = stage()
    s.enter(Phase.DEMONSTRATE)
    words_within(s, 1.0)
    s.enter(Phase.ABORTED)
    assert not s.cell.busy
    assert s.tick()
