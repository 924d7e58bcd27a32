"""What the cell does in each phase of a session: which set is on the table, and when the teacher acts and speaks."""

from __future__ import annotations

from mbd_model.objects import Role
from mbd_model.session import Phase

from mbd_cell.arm.hand import GripperCommand
from mbd_cell.cell import Cell
from mbd_cell.teacher.script import Word

# Later phases of a session have the target set on the table.
TARGET_PHASES = frozenset({Phase.OBSERVE_TARGET, Phase.ASSIST, Phase.EXECUTE})


class Stage:
    """Follows a session's phases with one cell.

    Attributes:
        phase: of the session, None before the first is received.
        unanswered: the last word said that the wizard has not acted on; the teacher says it again after a while.
    """

    def __init__(self, cell: Cell, teaches: bool) -> None:
        """Start without a session; ``teaches`` False leaves the demonstration to somebody else."""
        self.cell = cell
        self.phase: Phase | None = None
        self.unanswered: Word | None = None
        self._teaches = teaches
        self._used = False
        self._get_ready: Role | None = None
        self._words: list[Word] = []

    def enter(self, phase: Phase, again: bool = False) -> None:
        """The session is in this phase; ``again``: the operator asked for the present phase once more."""
        if phase is self.phase and not again:
            return
        self.phase = phase
        self.unanswered = None
        self._get_ready = None
        if phase is Phase.OBSERVE_SOURCE:
            self._prepare(Role.SOURCE)
        elif phase is Phase.DEMONSTRATE:
            self._demonstrate()
        elif phase is Phase.TUCK_AND_CLEAR:
            self._prepare(Role.TARGET)
        elif phase in TARGET_PHASES:
            # Only a cell that came late, or came back, still has the other set on its table.
            if self.cell.role is not Role.TARGET:
                self.cell.lay(Role.TARGET, self.cell.seed)
                self.cell.tuck()
        elif phase is Phase.ABORTED:
            self.cell.stop()

    def laid_again(self) -> None:
        """Somebody laid the table by hand: nothing has been moved on it yet."""
        self._used = False

    def tick(self) -> bool:
        """Let 10 ms pass; False while the teacher waits for the wizard."""
        passed = self.cell.tick()
        for word in self.cell.take_spoken():
            self._speak(word)
        if self._get_ready is not None and not self.cell.busy:
            role, self._get_ready = self._get_ready, None
            if self.cell.role is not role or self._used:
                self.cell.lay(role, self.cell.seed)
                self._used = False
            self._speak(Word.READY)
        return passed

    def take_words(self) -> list[Word]:
        """The words spoken since the last call."""
        words, self._words = self._words, []
        return words

    def gripper(self, command: GripperCommand) -> bool:
        """The wizard's gripper command; True when the hand heeds it."""
        heeded = self.cell.gripper(command)
        if heeded and self.unanswered in (Word.OPEN, Word.CLOSE):
            self.unanswered = None
        return heeded

    def begin(self) -> bool:
        """The demonstration is being recorded; True when the teacher waited for that."""
        begun = self.cell.begin()
        if begun:
            self.unanswered = None
        return begun

    def acknowledge(self, word: Word) -> None:
        """The wizard has acted on that word."""
        if self.unanswered is word:
            self.unanswered = None

    def _prepare(self, role: Role) -> None:
        self._get_ready = role
        self.cell.tuck()

    def _demonstrate(self) -> None:
        if not self._teaches:
            return
        if self.cell.role is not Role.SOURCE or self._used:
            self.cell.lay(Role.SOURCE, self.cell.seed)
        self._used = True
        self.cell.demonstrate()

    def _speak(self, word: Word) -> None:
        self._words.append(word)
        self.unanswered = word
