"""Whether a session's demonstration and assists are what the experimenter asked for (paper, Table 5).

The paper does not publish its criteria. Ours:

- A demonstration is consistent when its recorded (picked, placed onto) pairs are those of the script, each once, in any
  order.
- Assists are consistent when each names a right target for the step it answers as it was meant. In a consistent
  demonstration that is the step as recorded. In another the recorded step may be wrong, so it is the script's step of
  that number, counted with or without the recorded pairs the script has no place for (such as an object put aside).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from mbd_model.task import StepKind

from mbd_experiments.user_study.cases import Case
from mbd_experiments.user_study.study_facts import Pairs


def recorded_pairs(case: Case) -> Pairs:
    """(picked, placed onto) as recorded; () when picks and places do not alternate."""
    steps = case.task.steps
    kinds = [step.kind for step in steps]
    if kinds != [StepKind.PICK, StepKind.PLACE] * (len(steps) // 2):
        return ()
    names = [step.primary_object for step in steps]
    return tuple(zip(names[0::2], names[1::2], strict=True))


def demonstration_consistent(case: Case) -> bool:
    """Whether the recorded pairs are the script's."""
    return bool(case.script) and Counter(recorded_pairs(case)) == Counter(case.script)


def assists_consistent(case: Case) -> bool:
    """Whether every assist is right for the step as it was meant."""
    if not case.assists or not case.script:
        return False
    recorded: list[str | None] = [step.primary_object for step in case.task.steps]
    if demonstration_consistent(case):
        return _right(case, recorded)
    asked: list[str | None] = [name for pair in case.script for name in pair]
    # Counted without the recorded extra pairs, the assists must end with the script.
    as_asked = all(a.step_index < len(asked) for a in case.assists) and _right(case, asked)
    wanted = {pair[0] for pair in case.script}
    picks = Counter(pick for pick, _ in recorded_pairs(case))
    shifted: list[str | None] = []
    remaining = iter(case.script)
    for pick, onto in recorded_pairs(case):
        extra = pick not in wanted or (pick == onto and picks[pick] > 1)
        shifted += [pick, onto] if extra else list(next(remaining, (None, None)))
    return as_asked or _right(case, recorded) or _right(case, shifted)


def _right(case: Case, meant: Sequence[str | None]) -> bool:
    """Whether each assist names an acceptable target of the object meant at its step (None: anything will do)."""
    for assist in case.assists:
        name = meant[assist.step_index] if assist.step_index < len(meant) else None
        if name is not None and assist.target_id not in case.acceptable.get(name, frozenset()):
            return False
    return True
