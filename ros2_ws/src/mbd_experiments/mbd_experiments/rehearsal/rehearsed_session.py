"""One session of a rehearsal: a simulated participant, an operator who slips, forms at its end; in its bag."""

from __future__ import annotations

import shutil
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mbd_interaction.events import Event, Signal
from mbd_mapping.parameters import MAPPING, mapping_config
from mbd_model.errors import MbdError
from mbd_model.forms.form import StudyForm
from mbd_model.forms.reading import read_form
from mbd_model.session import Phase
from mbd_model.times import to_seconds

from mbd_experiments.in_process_session import Tape
from mbd_experiments.perceiving import cell_perception, perception_parameters
from mbd_experiments.rehearsal.answered_forms import due_forms, filled_by_chance, level_of
from mbd_experiments.rehearsal.clicking import ClickedAnswers
from mbd_experiments.rehearsal.holding import HeldPlan, SlipRates
from mbd_experiments.simulated_participants.error_model import Intention
from mbd_experiments.simulated_participants.script import ParticipantScript, participant_script
from mbd_experiments.simulated_participants.session import ParticipantSession, Settings
from mbd_experiments.simulated_participants.study import ATTEMPT_STRIDE, ATTEMPTS, Finished
from mbd_experiments.user_study.study_facts import INTENDED, ORIGIN, SCRIPT, Origin, script_text

CLICK_STREAM, FORM_STREAM = 22, 23  # of chance


@dataclass(frozen=True)
class RehearsalTask:
    """One session to hold.

    Attributes:
        held: when and how it is held.
        intention: what the participant gets wrong.
        parameters: of the mapping, as the condition's arguments set them.
        forms: names of the forms there are.
        first, last: the participant's first session, and the last of its condition.
        rates: of the operator's slips.
        study: name of the study.
        seed: of the rehearsal.
    """

    held: HeldPlan
    intention: Intention
    parameters: Mapping[str, str | float]
    forms: tuple[str, ...]
    first: bool
    last: bool
    rates: SlipRates
    study: str
    seed: int

    @property
    def name(self) -> str:
        """Of the session and its folder."""
        return self.held.planned.session


class RehearsedSession(ParticipantSession):
    """A participant's session at whose console an operator sits."""

    def __init__(
        self, task: RehearsalTask, script: ParticipantScript, settings: Settings, seed: int, tape: Tape
    ) -> None:
        self._slips = np.random.default_rng([seed, CLICK_STREAM])
        self._task, self._rates = task, task.rates
        self._clicks = ClickedAnswers(script, task.rates, self._slips)
        self.wrong_buttons = 0
        super().__init__(task.name, script, seed, settings, tape, answering=self._clicks)

    @property
    def wrong_objects(self) -> int:
        """How many answers were clicked on another object."""
        return self._clicks.wrong

    def run(self) -> Phase:
        """The complete session; returns the phase it ended in, ABORTED where the participant wanted to stop."""
        self.prepare()
        if self._task.held.ended_early and self.loop.dialogue.phase is not Phase.ABORTED:
            self._end_early()  # the robot was sure before a second question
        if self.loop.dialogue.phase is not Phase.ABORTED:
            self.next_phase()
        return self.loop.dialogue.phase

    def next_phase(self) -> None:
        """The operator leads on, now and then after a wrong button."""
        if self._slips.random() < self._rates.click:
            self.wrong_buttons += 1
            self._press(Signal.UNDO)
            self.cell_session.pass_time(1.0)
            # Where the button did something, the robot asks again.
            while self.loop.dialogue.phase is Phase.ASSIST:
                self.answer()
        if self.loop.dialogue.phase is not Phase.ABORTED:
            super().next_phase()

    def answer(self) -> None:
        """As the participant answers; a wrong click that was noticed is taken back, and the robot asks again."""
        if self._task.held.ended_early and self.answers >= 1:
            self._end_early()
            return
        super().answer()
        if self._clicks.misclicked and self.loop.dialogue.phase is Phase.ASSIST and self.loop.dialogue.assists:
            self.cell_session.pass_time(1.5)
            self._press(Signal.UNDO)

    def _end_early(self) -> None:
        self._press(Signal.ABORT)
        self.note("deviation: the participant wanted to stop")

    def note(self, text: str) -> None:
        """The operator writes a note."""
        now = self.cell_session.now
        self.tape.write("wizard/note", text, now)
        self.loop.feed(Event(Signal.NOTE, now, "wizard/note"))

    def fill_in(self, form: StudyForm, level: float, rng: np.random.Generator) -> None:
        """The participant fills a form in, half a minute long."""
        opened = to_seconds(self.cell_session.now)
        self.cell_session.pass_time(30.0)
        answers = filled_by_chance(form, level, rng)
        self.tape.write("study/form", (answers, int(self.loop.dialogue.phase), opened), self.cell_session.now)

    def _press(self, signal: Signal) -> None:
        now = self.cell_session.now
        self.tape.write("wizard/command", signal, now)
        self.loop.feed(Event(signal, now, "wizard/command"))


def hold(task: RehearsalTask, out: Path, scenes: Path, knowledge: Path) -> Finished | str:
    """One session into its bag below ``out``; or why it failed, every time.

    Args:
        task: the session.
        out: folder of the study's sessions.
        scenes: folder of the cell's configuration.
        knowledge: perception's knowledge base.
    """
    started, troubles = time.perf_counter(), list[str]()
    bag = out / task.name / "bag"
    while len(troubles) < ATTEMPTS:
        # What an earlier try, or a killed process, has left is no bag yet.
        shutil.rmtree(bag, ignore_errors=True)
        try:
            seconds = _held(task, len(troubles), bag, scenes, knowledge)
        except MbdError as error:
            troubles.append(str(error))
            continue
        return Finished(bag, seconds, time.perf_counter() - started, tuple(troubles))
    shutil.rmtree(bag, ignore_errors=True)
    return f"failed {ATTEMPTS} times, at last because {troubles[-1]}"


def _held(task: RehearsalTask, attempt: int, path: Path, scenes: Path, knowledge: Path) -> float:
    """Simulated seconds of a session; raises MbdError when it did not come to its end."""
    # Messages are needed to write bags only; what a session is works without ROS.
    from mbd_bag.session.session_facts import package_versions, parameter_facts
    from mbd_bag.storage.bag_writer import BagWriter
    from mbd_cell.layout.scene_file import load_scenes

    from mbd_experiments.ros.cell_conversions import BagTape

    planned, held = task.held.planned, task.held
    values = MAPPING.values(dict(task.parameters))
    threshold = float(values["threshold"])
    settings = Settings(cell_perception(scenes, knowledge), mapping_config(values), threshold)
    seed = (planned.seed + attempt * ATTEMPT_STRIDE) % (2**31 - 1)
    path.parent.mkdir(parents=True, exist_ok=True)
    with BagWriter(path) as bag:
        script = participant_script(load_scenes(scenes / f"{task.intention.task}.yaml"), task.intention, seed)
        session = RehearsedSession(task, script, settings, seed, BagTape(task.name, bag))
        plan = {"study": task.study, "session": planned.session, "condition": planned.condition}
        plan |= {"position": str(planned.position), "deviation": held.deviation, "instead_of": held.instead_of}
        bag.add_facts(
            {
                "session": task.name,
                "participant": planned.participant,
                "task": planned.task,
                "seed": str(seed),
                "begun": str(held.begun),
                ORIGIN: str(Origin.SIMULATED),
                SCRIPT: script_text(script.asked),
                INTENDED: task.intention.words,
            }
            | {f"plan.{name}": value for name, value in plan.items() if value}
            | package_versions()
        )
        bag.add_facts(parameter_facts("/perception", perception_parameters(scenes)))
        bag.add_facts(parameter_facts("/mapping", values))
        forms = due_forms({name: read_form(name) for name in task.forms}, task.first, task.last)
        rng = np.random.default_rng([seed, FORM_STREAM])
        before = [form for form in forms if form.consent or form.name == "demographics"]
        for form in before:
            session.fill_in(form, 0.5, rng)
        ended = session.run()
        if ended is not (Phase.ABORTED if held.ended_early else Phase.DONE):
            raise MbdError(f"the session ended in {ended.name}")
        level = level_of(planned.participant, planned.condition, session.asked, task.seed)
        for form in forms:
            if form not in before and ended is Phase.DONE:
                session.fill_in(form, level, rng)
        slips = {"objects": session.wrong_objects, "buttons": session.wrong_buttons}
        bag.add_facts({f"operator.wrong_{name}": str(count) for name, count in slips.items()})
        return session.seconds
