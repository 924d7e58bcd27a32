from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from mbd_cell.layout.scene_file import load_scenes
from mbd_experiments.execution_trials.teacher_errors import drawn_errors
from mbd_experiments.execution_trials.trial_session import trial_scenes
from mbd_experiments.execution_trials.trial_teacher import TrialTeacher
from mbd_experiments.simulated_participants.script import ParticipantScript, participant_script
from mbd_interaction.config import DialogueConfig
from mbd_interaction.dialogue import AskedQuestion, Dialogue
from mbd_interaction.restore import begun
from mbd_model.assists import Assist, AssistKind
from mbd_model.objects import Role
from mbd_model.session import PromptKind

CONFIG = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_cell" / "config"


@pytest.fixture(scope="module")
def script() -> ParticipantScript:
    scenes = trial_scenes(load_scenes(CONFIG / "stacking.yaml"), 2)
    return participant_script(scenes, drawn_errors("stacking", 2, ()))


def asked(script: ParticipantScript, kind: PromptKind, wrong: bool) -> Dialogue:
    """A question after one answer; ids are the true names here."""
    source = min(script.preference)
    right = script.preference[source]
    others = sorted(o.name for o in script.scenes.target if o.name not in right)
    assist = Assist(source, others[0] if wrong else right[0], 3, AssistKind.HANDED, 0.0, confirmed=True)
    return replace(begun("s", DialogueConfig(), ""), question=AskedQuestion(kind), assists=(assist,))


@pytest.mark.parametrize("wrong", [True, False])
@pytest.mark.parametrize("kind", [PromptKind.PUT_IT_RIGHT, PromptKind.IS_THIS_IT])
@pytest.mark.parametrize("lied", [True, False])
def test_who_lied_once_takes_it_back_when_the_robot_asks_for_help_with_what_came_of_it(
    script: ParticipantScript, wrong: bool, kind: PromptKind, lied: bool
):
    teacher = TrialTeacher(script, lies=True)
    teacher.lied = lied
    for role, objects in ((Role.SOURCE, script.scenes.source), (Role.TARGET, script.scenes.target)):
        teacher.see(role, {o.name: o.name for o in objects})
    corrected = teacher.corrected(asked(script, kind, wrong))
    if wrong and lied and kind is PromptKind.PUT_IT_RIGHT:
        assert corrected == (3, script.preference[min(script.preference)][0])
    else:
        assert corrected is None
