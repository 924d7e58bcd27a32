"""A session's arguments taken from a study's plan: which session is next, and where what is held is not as planned."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from mbd_model.errors import MbdError
from mbd_model.parameters import nearest
from mbd_model.session import Phase
from mbd_study.plan.protocol import HeldSession, held_sessions, next_session, read_reasons
from mbd_study.plan.schedule import PlannedSession, planned_sessions
from mbd_study.plan.study_plan import read_plan


@dataclass(frozen=True)
class PlannedWords:
    """What is started.

    Attributes:
        words: the session's arguments by name, completed from the plan.
        facts: what its bag states of the plan, ``name=value`` each; ``deviation`` where it is left.
        planned: the session of the plan; None when it has no such.
    """

    words: dict[str, str]
    facts: tuple[str, ...]
    planned: PlannedSession | None


def planned_words(words: Mapping[str, str], given: Collection[str]) -> PlannedWords:
    """The plan's next session, or the one that is asked for.

    Args:
        words: argument name -> what was given for it, with ``plan``, its file, and ``folder``, of the sessions.
        given: names of those that a person gave: they go before the plan's, and are stated where they leave it.

    Raises:
        MbdError: the plan cannot be used, or nothing is left of it.
    """
    plan = read_plan(Path(words["plan"]).expanduser())
    planned = planned_sessions(plan)
    folder = Path(words["folder"]).expanduser()
    held = held_sessions(folder)[0] if folder.is_dir() else ()
    usual = next_session(
        planned,
        held,
        read_reasons(folder) if folder.is_dir() else {},
        words["participant"] if "participant" in given else "",
    )
    chosen = _chosen(words, given, planned, held, usual)
    own = {} if chosen is None else _own_words(chosen)
    left = []
    # To go on with a session is not to hold it before another.
    interrupted = words["resume"].lower() == "true"
    if usual is not None and usual != chosen and not interrupted:
        left.append(f"held when {usual.session} was next")
    if chosen is None:
        left.append("not planned")
    for name in sorted(set(given) & set(own)):
        if words[name] != own[name]:
            left.append(f"{name} is {words[name] or 'empty'}, planned was {own[name]}")
    made = {**words, **{name: word for name, word in own.items() if name not in given}}
    if left and words["deviation"]:
        left = [f"{'; '.join(left)}: {words['deviation']}"]
    elif words["deviation"]:
        left = [words["deviation"]]
    facts = [f"study={plan.study}"]
    if chosen is not None:
        facts += [f"session={chosen.session}", f"condition={chosen.condition}", f"position={chosen.position}"]
    if left:
        facts.append(f"deviation={'; '.join(left)}")
    if usual is not None and usual != chosen and not interrupted and _same_person(usual, chosen, made):
        facts.append(f"instead_of={usual.session}")
    return PlannedWords(made, tuple(facts), chosen)


def _same_person(usual: PlannedSession, chosen: PlannedSession | None, words: Mapping[str, str]) -> bool:
    return usual.participant == (chosen.participant if chosen else words["participant"])


def _own_words(one: PlannedSession) -> dict[str, str]:
    """The arguments that the plan means for a session."""
    own = {"session": one.session, "participant": one.participant, "task": one.task, "seed": str(one.seed)}
    return {**own, **{name: value for name, _, value in (word.partition(":=") for word in one.arguments)}}


def _chosen(
    words: Mapping[str, str],
    given: Collection[str],
    planned: Sequence[PlannedSession],
    held: Sequence[HeldSession],
    usual: PlannedSession | None,
) -> PlannedSession | None:
    """The planned session that is asked for, None when the plan has no such; raises MbdError when none is next."""
    by_name = {p.session: p for p in planned}
    if "session" in given and words["session"]:
        return by_name.get(words["session"])
    if words["resume"].lower() == "true":
        left_off = [h.session for h in held if h.phase is not Phase.DONE and h.session in by_name]
        if not left_off:
            raise MbdError(
                "resume:=true goes on with a session that was interrupted, and the plan has none; leave it out"
            )
        return by_name[left_off[-1]]
    people = dict.fromkeys(p.participant for p in planned)
    if usual is None and "participant" in given and words["participant"] not in people:
        near = nearest(words["participant"], people)
        advice = f"did you mean '{near}'?" if near else f"it has {', '.join(people)}"
        raise MbdError(f"the plan {words['plan']} has no participant '{words['participant']}'; {advice}")
    if usual is None:
        whose = f" of {words['participant']}" if "participant" in given else ""
        raise MbdError(
            f"every session{whose} in the plan {words['plan']} was held or given up: nothing is next; "
            "name a session by session:=, or go on with one by resume:=true"
        )
    if "task" not in given or words["task"] == usual.task:
        return usual
    done = {h.session for h in held}
    left = [
        p for p in planned
        if p.participant == usual.participant and p.task == words["task"] and p.session not in done
    ]  # fmt: skip
    same = [p for p in left if p.condition == usual.condition]
    return next(iter(same or left), None)
