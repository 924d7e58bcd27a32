"""Keys that mark a moment in the bag, and notes written by one press. Their words are in the table of texts."""

from __future__ import annotations

from mbd_model.session import Phase

from mbd_console.words.texts import PageTexts

# Key -> name of the marker, as the bag has it; letters that no action of the console has.
MARKERS = {
    "h": "hesitates",
    "q": "question",
    "f": "robot_fault",
    "i": "interruption",
    "g": "quote",
    "a": "teacher_acts",
}
PHRASES = ("phrase_1", "phrase_2", "phrase_3")
CHECKLIST, COUNTDOWN = "checklist", "countdown"  # markers of notes that a page writes itself


def checks(phase: Phase | None, texts: PageTexts) -> tuple[tuple[str, str], ...]:
    """The entries of a phase's checklist, as (name, words)."""
    if phase is None:
        return ()
    words = texts(f"check_{phase.name}").split("|")
    return tuple((f"{phase.name} {number}", text) for number, text in enumerate(words, start=1))
