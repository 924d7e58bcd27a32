"""Two sessions with twenty faults, every node a victim: they end as if nothing had happened, and nothing is lost."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_share_directory
from mbd_bag.session.command_line import open_session
from mbd_bag.session.recorded_session import RecordedReply
from mbd_bringup.chaos.faults import FaultKind, PlannedFault, draw_sessions
from mbd_bringup.chaos.verdict import SessionFindings, faults_of_result, findings_of
from mbd_bringup.nodes import SessionOptions, session_nodes
from mbd_bringup.ros.chaos.disturbed_session import DisturbedSession, disturbed_session
from mbd_bringup.ros.chaos.trials import ChaosOptions
from mbd_bringup.ros.follow import SessionEvent
from mbd_bringup.ros.live_session import LiveSession
from mbd_cell.layout.scene_file import load_scenes
from mbd_model.ros.qos import EVENTS
from mbd_model.session import Phase, Prompt, PromptKind
from mbd_model.task import StepKind
from mbd_msgs.msg import WizardCommand, WizardHanded
from mbd_study.tables.correctness import answers_of

pytestmark = pytest.mark.timeout(1500)

# Those that need no more than a session of the cell: a network of its own takes root.
KINDS = (
    FaultKind.KILL,
    FaultKind.STOP,
    FaultKind.INTERRUPT,
    FaultKind.TERMINATE,
    FaultKind.CLOCK,
    FaultKind.DISK,
)
FAULTS = 10  # of each session


class WrongWizard:
    """States at certain moments what cannot be so, besides the wizard who does it right."""

    def __init__(self) -> None:
        self._out: dict[type, object] = {}

    def on_event(self, live: LiveSession, event: SessionEvent) -> None:
        """Publish something wrong, if this is the moment."""
        if not self._out:
            for kind, topic in ((WizardHanded, "wizard/handed"), (WizardCommand, "wizard/command")):
                self._out[kind] = live.follower.create_publisher(kind, topic, EVENTS)
        if event.phase is Phase.DEMONSTRATE:
            self._out[WizardHanded].publish(WizardHanded(object_id="t1"))  # nothing was asked yet
            self._out[WizardCommand].publish(WizardCommand(command=99))  # no such command
        elif event.phase is Phase.OBSERVE_TARGET:
            # There is no assist to withdraw.
            self._out[WizardCommand].publish(WizardCommand(command=WizardCommand.UNDO))
        elif isinstance(event.fact, Prompt) and event.fact.kind is PromptKind.WHAT_DO_I_USE:
            self._out[WizardHanded].publish(WizardHanded(object_id="teapot"))  # no such object


@dataclass
class Trial:
    """What was planned, what came of it."""

    options: SessionOptions
    faults: tuple[PlannedFault, ...]
    went: DisturbedSession
    refused: list[str] = field(default_factory=list)


@pytest.fixture(scope="module", params=[0, 1], ids=["first", "second"])
def trial(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Trial:
    # No confidence reaches 1, so every step is asked about and there is an assist loop to kill nodes in.
    folder = tmp_path_factory.mktemp("chaos") / "session"
    options = SessionOptions("chaos", folder, task="sorting", seed=1, threshold=1.0, speed=0.0)
    victims = [spec.executable for spec in session_nodes(options)]
    faults = draw_sessions(2, FAULTS, KINDS, victims, seed=4, execute=False)[request.param]
    went = disturbed_session(options, faults, timeout=1200.0, watch=WrongWizard().on_event)
    return Trial(options, faults, went, [r.reason for r in went.replies if not r.accepted])


def expected(bag: Path) -> SessionFindings:
    """What the scene file says is to be found; of the mapping, what the bag has, once that is right."""
    session = open_session(bag)[1]
    answers, found = answers_of(session), findings_of(bag)
    used = session.tasks[-1].value.used_objects
    assert answers is not None
    assert answers.maps_right(session.estimates[-1][0].value.executed, used)
    scenes = load_scenes(Path(get_package_share_directory("mbd_cell")) / "config" / "sorting.yaml")
    steps = tuple((s.kind.name.lower(), s.picked if s.kind is StepKind.PICK else s.onto) for s in scenes.steps)
    return SessionFindings(steps, len(steps), found.mapping)


def test_a_session_to_whose_nodes_ten_things_happen_finds_what_it_finds_undisturbed_and_loses_no_word(trial: Trial):
    went = trial.went
    assert not went.problem
    struck = Counter(f.kind for f in went.struck)
    assert struck[FaultKind.KILL] >= 4, went.missed
    assert went.hanging == []
    assert faults_of_result(trial.options.bag, went.phase, expected(trial.options.bag), went.replies) == ()


def test_wrong_wizard_events_are_refused_with_a_reason_and_change_nothing(trial: Trial):
    assert trial.refused
    assert all(trial.refused)
    assert isinstance(trial.went.replies[0], RecordedReply)


def test_every_node_of_a_session_is_a_victim():
    options = ChaosOptions(
        10, 10, 1, tuple(FaultKind), ("sorting",), True, "ur5e", "realsense", Path("session"), timeout=900.0
    )
    victims = set(options.victims)
    assert victims >= {"robot", "camera", "execution", "console", "cell", "wizard", "recorder", "spool", "second_spool"}
    plans = draw_sessions(10, 10, tuple(FaultKind), sorted(victims), seed=1, execute=True)
    killed = Counter(f.victim for faults in plans for f in faults if f.kind is FaultKind.KILL)
    assert set(killed) == victims
    assert max(killed.values()) - min(killed.values()) <= 1
    assert all(len({f.mark for f in faults}) == 10 for faults in plans)
    assert plans == draw_sessions(10, 10, tuple(FaultKind), sorted(victims), seed=1, execute=True)
