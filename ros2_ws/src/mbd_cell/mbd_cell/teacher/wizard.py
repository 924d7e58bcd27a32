"""The scripted wizard: the operator who turns the teacher's words and gestures into wizard events, without ROS.

Level triggered: ``next_request`` looks at what is known now, so a wizard that starts late, or again, continues. One
event at a time: the next is sent when the dialogue has replied to the last.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from enum import StrEnum

from mbd_model.objects import Role, Scene
from mbd_model.session import Phase, Prompt, PromptKind, SessionState

from mbd_cell.teacher.recognition import TrueTable, is_right, recognise, right_target
from mbd_cell.teacher.script import Word

# After a refusal the wizard waits before he tries again, twice as long each time, in wall-clock seconds.
RETRY_AFTER, LONGEST_RETRY = 0.5, 8.0
REPLY_TIMEOUT = 30.0  # [s] wall clock
MAX_ANSWERS = 2  # to questions about one step, and as often helped with it: a robot asks again when it failed at it


class WizardAct(StrEnum):
    """Everything the scripted wizard does; the value names the wizard topic."""

    OPEN = "wizard/gripper:OPEN"
    CLOSE = "wizard/gripper:CLOSE"
    START = "wizard/demonstration:START"
    STOP = "wizard/demonstration:STOP"
    NEXT_PHASE = "wizard/command:NEXT_PHASE"
    REDO = "wizard/command:REDO"
    SKIP = "wizard/command:SKIP"
    HANDED = "wizard/handed"
    POINTED = "wizard/pointed"
    YES = "wizard/answer:YES"
    NO = "wizard/answer:NO"

    @property
    def topic(self) -> str:
        """The topic it goes to."""
        return self.value.partition(":")[0]


@dataclass(frozen=True)
class WizardEvent:
    """One wizard event to send, with the target object it names ("" for none) and why, for the log."""

    act: WizardAct
    why: str
    object_id: str = ""

    @property
    def awaits_reply(self) -> bool:
        """The hand's motion is answer enough to a gripper command."""
        return self.act not in (WizardAct.OPEN, WizardAct.CLOSE)


@dataclass
class Wizard:
    """What the wizard knows.

    Attributes:
        wrong_step: index of the step that gets one wrong assist; -1 for none.
        reply_timeout: an event without a reply counts as lost after this [s].
        tables: true tables by role.
        scenes: perceived scenes by role.
        robot_at_work: a robot executes the task in EXECUTE and has not finished; then he waits.
    """

    wrong_step: int = -1
    reply_timeout: float = REPLY_TIMEOUT
    tables: dict[Role, TrueTable] = field(default_factory=dict)
    scenes: dict[Role, Scene] = field(default_factory=dict)
    state: SessionState | None = None
    prompt: Prompt | None = None
    robot_at_work: bool = False
    _prompt_number: int = 0
    _answered: int = 0
    _word: Word | None = None
    _stepped: tuple[Phase, int] | None = None
    _pending: WizardEvent | None = None
    _sent_in: tuple[Phase, int] | None = None
    _sent_for: tuple[int, Prompt | None] = (0, None)  # number of the prompt answered, and the prompt
    _sent_at: float = 0.0
    _not_before: float = 0.0
    _refusals: int = 0
    _erred: bool = False
    _answers: Counter[int] = field(default_factory=Counter)
    _helped: Counter[int] = field(default_factory=Counter)

    def on_word(self, word: Word) -> None:
        """The teacher said something."""
        self._word = word

    def see_prompt(self, prompt: Prompt) -> None:
        """The robot published a prompt; each is answered once."""
        self.prompt = prompt
        self._prompt_number += 1
        # A refusal is said in a prompt, too, which is not to have it forgotten.
        if prompt.kind is not PromptKind.INFORM:
            self._refusals = 0

    def see_state(self, state: SessionState) -> None:
        """The dialogue's state."""
        if self.state is None or state.phase is not self.state.phase:
            self._refusals = 0
        self.state = state

    def next_request(self, now: float, replies: bool) -> WizardEvent | None:
        """What to send now, None for nothing.

        Args:
            now: wall-clock time [s].
            replies: True when somebody answers wizard events; else none is waited for.
        """
        if self._pending is not None:
            if now - self._sent_at < self.reply_timeout:
                return None
            self._pending = None
        if now < self._not_before:
            return None
        request = self._choose()
        if request is None:
            return None
        # The state may have moved on by the time the reply comes: what was stepped from is what was true when sending.
        self._sent_in = (self.state.phase, self.state.num_events) if self.state else None
        self._sent_for = (self._prompt_number, self.prompt)
        if request.awaits_reply and replies:
            self._pending, self._sent_at = request, now
        else:
            self._settle(request)
        return request

    def reply(self, topic: str, accepted: bool, now: float) -> WizardEvent | None:
        """A reply came on that topic; returns the request it answers, None when it is not for this wizard."""
        request = self._pending
        if request is None or not topic.endswith(request.act.topic):
            return None
        self._pending = None
        if accepted:
            self._refusals = 0
            self._settle(request)
            return request
        self._refusals += 1
        self._not_before = now + min(RETRY_AFTER * 2**self._refusals, LONGEST_RETRY)
        return request

    def _settle(self, request: WizardEvent) -> None:
        if request.act in (WizardAct.OPEN, WizardAct.CLOSE, WizardAct.START, WizardAct.STOP, WizardAct.REDO):
            self._word = None
        elif request.act is WizardAct.NEXT_PHASE:
            self._word = None
            self._stepped = self._sent_in
        else:
            # The next question may come before the reply to this answer.
            self._answered, prompt = self._sent_for
            step = prompt.step_index if prompt else -1
            if request.act is WizardAct.NO:
                self._answers[step] = 0  # what was withdrawn is answered afresh
            elif request.act is not WizardAct.YES:
                self._answers[step] += 1
                self._erred = self._erred or (step >= 0 and step == self.wrong_step)
            elif prompt is not None and prompt.kind is PromptKind.PUT_IT_RIGHT:
                self._helped[step] += 1

    def _choose(self) -> WizardEvent | None:
        phase = self.state.phase if self.state else None
        if self.state is not None and self.state.paused:
            return None
        if self._word is Word.OPEN:
            return WizardEvent(WizardAct.OPEN, "the teacher said open")
        if self._word is Word.CLOSE:
            return WizardEvent(WizardAct.CLOSE, "the teacher said close")
        if self._word in (Word.DEMONSTRATION_BEGINS, Word.DEMONSTRATION_ENDS):
            return self._record(phase)
        if self._word is Word.READY:
            if phase in (Phase.OBSERVE_SOURCE, Phase.TUCK_AND_CLEAR):
                return WizardEvent(WizardAct.NEXT_PHASE, "the table is ready")
            return None
        if phase in (Phase.OBSERVE_TARGET, Phase.EXECUTE) and self.state is not None:
            if self._stepped == (phase, self.state.num_events) or (phase is Phase.EXECUTE and self.robot_at_work):
                return None
            why = "the target objects can be seen" if phase is Phase.OBSERVE_TARGET else "the robot knows how to go on"
            return WizardEvent(WizardAct.NEXT_PHASE, why)
        if phase is Phase.ASSIST:
            return self._assist()
        return None

    def _record(self, phase: Phase | None) -> WizardEvent | None:
        if phase not in (None, Phase.DEMONSTRATE):
            return None
        # Refused again and again: the recording is of another attempt, or of no use. Then it is shown once more.
        if self._refusals >= 2:
            return WizardEvent(WizardAct.REDO, "the demonstration could not be recorded")
        if self._word is Word.DEMONSTRATION_BEGINS:
            return WizardEvent(WizardAct.START, "the teacher begins")
        return WizardEvent(WizardAct.STOP, "the teacher has finished")

    def _assist(self) -> WizardEvent | None:
        prompt = self.prompt
        # A question about the demonstration may still be the last one just after ASSIST began; it is left unanswered.
        if prompt is None or prompt.kind in (PromptKind.INFORM, PromptKind.WHICH_WAS_MEANT):
            return None
        if self._answered == self._prompt_number:
            return None
        if set(self.scenes) != set(Role) or set(self.tables) != set(Role) or self.state is None:
            return None
        if max(self._answers[prompt.step_index], self._helped[prompt.step_index]) >= MAX_ANSWERS:
            return WizardEvent(
                WizardAct.SKIP, f"step {prompt.step_index + 1} failed again and again: the robot leaves it out"
            )
        if prompt.kind is PromptKind.PUT_IT_RIGHT:
            return WizardEvent(WizardAct.YES, f"the robot may try step {prompt.step_index + 1} again")
        names = {role: recognise(self.scenes[role], self.tables[role].places) for role in Role}
        if prompt.target_ids:
            return self._named(prompt, names)
        used = [a.target_id for a in self.state.assists]
        wrong = prompt.step_index == self.wrong_step and not self._erred
        target = right_target(prompt.source_id, names, self.tables[Role.TARGET].solution, used=used, wrong=wrong)
        if target is None:
            seen = names[Role.SOURCE].get(prompt.source_id, "an object the wizard does not recognise")
            return WizardEvent(WizardAct.SKIP, f"no target is left for {prompt.source_id} ({seen})")
        act = WizardAct.HANDED if prompt.kind is PromptKind.WHAT_DO_I_USE else WizardAct.POINTED
        seen = names[Role.SOURCE][prompt.source_id]
        chosen = names[Role.TARGET][target]
        return WizardEvent(act, f"for {seen} the teacher {'wrongly ' if wrong else ''}gives {chosen}", target)

    def _named(self, prompt: Prompt, names: dict[Role, dict[str, str]]) -> WizardEvent | None:
        """The true answer to a question that names target objects."""
        solution, used = self.tables[Role.TARGET].solution, set[str]()
        if prompt.kind is not PromptKind.CONFIRM_ASSIST and self.state is not None:
            used = {a.target_id for a in self.state.assists}
        right = [t for t in prompt.target_ids if t not in used and is_right(prompt.source_id, t, names, solution)]
        seen = names[Role.SOURCE].get(prompt.source_id, prompt.source_id)
        named = " or ".join(names[Role.TARGET].get(t, t) for t in prompt.target_ids)
        if not right:
            return WizardEvent(WizardAct.NO, f"{named} is not for {seen}")
        if prompt.kind is not PromptKind.WHICH_OF_TWO:
            return WizardEvent(WizardAct.YES, f"{named} is for {seen}")
        chosen = names[Role.TARGET][right[0]]
        return WizardEvent(WizardAct.POINTED, f"for {seen} of the two it is {chosen}", right[0])
