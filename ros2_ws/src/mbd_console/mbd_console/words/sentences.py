"""What the robot says, wants and does, in words for who never saw it: made of typed fields, not of sentences."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from mbd_model.execution_progress import Purpose, Status
from mbd_model.objects import Role, Scene
from mbd_model.session import Phase, PromptKind
from mbd_model.task import StepKind

from mbd_console.outlines import outlines
from mbd_console.state import ConsoleState, asks
from mbd_console.words.texts import PageTexts
from mbd_console.words.things import ThingName, nothing_named, thing_names

_ARM = {
    Purpose.PICK: "arm_pick",
    Purpose.PLACE: "arm_place",
    Purpose.FETCH: "arm_fetch",
    Purpose.RETURN: "arm_return",
    Purpose.LET_GO: "arm_let_go",
}


@dataclass(frozen=True)
class LayNames:
    """What the objects of both scenes are called."""

    source: Mapping[str, ThingName]
    target: Mapping[str, ThingName]
    nothing: ThingName

    def of(self, role: Role, object_id: str) -> ThingName:
        """The name of an object, "this thing" for one that is not known."""
        return (self.source if role is Role.SOURCE else self.target).get(object_id, self.nothing)


def lay_names(state: ConsoleState, texts: PageTexts) -> LayNames:
    """Names of all objects that the page shows."""
    source = state.task.source if state.task else state.source
    others = {Role.SOURCE: state.target, Role.TARGET: source}

    def names(role: Role, scene: Scene | None) -> dict[str, ThingName]:
        other = others[role]
        return thing_names(scene, texts, _along(state, scene), other.objects if other else ()) if scene else {}

    return LayNames(names(Role.SOURCE, source), names(Role.TARGET, state.target), nothing_named(texts))


def _along(state: ConsoleState, scene: Scene) -> dict[str, float]:
    """How far to the right objects appear: in the camera's picture [px], else as the robot sees them [m]."""
    if state.view is None:
        return {o.object_id: -o.centroid[1] for o in scene.objects}
    return {o.thing.object_id: o.middle[0] for o in outlines(state.view, scene.objects)}


def robot_says(state: ConsoleState, texts: PageTexts, names: LayNames) -> str:
    """The robot's sentence."""
    if state.standing:
        return texts("say_stands")
    session, prompt = state.session, state.prompt
    if session is None:
        return texts("say_none")
    if session.paused:
        return texts("say_paused")
    if state.study.shown:
        return texts("say_form")
    if prompt is None or not asking(state) or not texts.has(f"ask_{prompt.kind.name}"):
        return texts(f"say_{session.phase.name}")
    targets = [names.of(Role.TARGET, i) for i in (*prompt.target_ids, "", "")]
    source = names.of(Role.SOURCE, prompt.source_id)
    others = [names.of(Role.SOURCE, i) for i in prompt.source_ids]
    if prompt.kind is PromptKind.WHICH_WAS_MEANT and len(others) == 2:
        return texts("ask_WHICH_WAS_MEANT", source=others[0].accusative, other=others[1].accusative)
    return texts(
        f"ask_{prompt.kind.name}",
        source=source.accusative,
        target=targets[0].accusative,
        target_nom=targets[0].nominative,
        other=targets[1].accusative,
        other_nom=targets[1].nominative,
    )


def asking(state: ConsoleState) -> bool:
    """Whether the robot waits for the answer to a question, and no form comes first."""
    return (
        not state.study.shown
        and asks(state.prompt)
        and bool(state.asked or state.candidates or state.phase is Phase.EXECUTE)
    )


def you_do(state: ConsoleState, texts: PageTexts) -> str:
    """What is wanted of the participant."""
    session, prompt = state.session, state.prompt
    if state.study.shown:
        return texts("you_form", send=texts("form_send"))
    if session is None or session.paused or state.standing:
        return texts("you_wait")
    if prompt is not None and asking(state) and texts.has(f"you_{prompt.kind.name}"):
        return texts(f"you_{prompt.kind.name}")
    if session.phase is Phase.DEMONSTRATE and session.recording:
        return texts("you_recording")
    if session.phase in (Phase.ASSIST, Phase.EXECUTE):
        return texts("you_watch" if session.phase is Phase.EXECUTE else "you_wait")
    if session.phase in (Phase.DONE, Phase.ABORTED):
        return texts("you_DONE")
    return texts(f"you_{session.phase.name}")


def arm_does(state: ConsoleState, texts: PageTexts, names: LayNames) -> str:
    """What the arm does now."""
    session, progress = state.session, state.progress
    if session is None or session.paused or state.standing:
        return texts("arm_rests")
    if session.phase is Phase.EXECUTE and progress is not None:
        if progress.status is Status.FAILED:
            return texts("arm_failed")
        if progress.status is Status.FINISHED:
            return texts("arm_finished")
        if progress.status is not Status.UNDER_WAY:
            return texts("arm_none")
        if progress.purpose not in _ARM:
            return texts("arm_look" if progress.purpose is not Purpose.NONE else "arm_none")
        thing = names.of(Role.TARGET, progress.object_id).accusative
        onto = progress.purpose is Purpose.PLACE and progress.receiver_id
        receiver = names.of(Role.TARGET, progress.receiver_id).accusative
        return texts(f"{_ARM[progress.purpose]}{'_onto' if onto else ''}", thing=thing, receiver=receiver)
    if session.phase is Phase.DEMONSTRATE:
        return texts("arm_guided" if session.recording else "arm_rests")
    if session.phase is Phase.TUCK_AND_CLEAR:
        return texts("arm_tucks")
    return texts("arm_waits" if asking(state) else "arm_rests")


def plan(state: ConsoleState, texts: PageTexts, names: LayNames) -> tuple[str, ...]:
    """What the robot is going to do, a sentence for each object; () before it saw the new ones, and once it is over."""
    going_on = state.phase not in (None, Phase.OBSERVE_SOURCE, Phase.DONE, Phase.ABORTED)
    if state.estimate is None or state.target is None or not state.steps or not going_on:
        return ()
    pairs = state.estimate.executed.as_dict
    told = {a.source_id: a.target_id for a in state.session.assists} if state.session else {}
    pairs |= told
    picked = {s.primary_object for s in state.steps if s.kind is StepKind.PICK}
    found = []
    for source_id in dict.fromkeys(s.primary_object for s in state.steps):
        source = names.of(Role.SOURCE, source_id).accusative
        if source_id not in pairs:
            found.append(texts("plan_none", source=source))
            continue
        kind = "plan_move" if source_id in picked else "plan_onto"
        said = texts(kind, target=names.of(Role.TARGET, pairs[source_id]).accusative, source=source)
        found.append(said.rstrip(".") + texts("told_mark") + "." if source_id in told else said)
    return tuple(found)


def why(state: ConsoleState, texts: PageTexts) -> str:
    """By what it decided, for who asks."""
    estimate = state.estimate
    if estimate is None or not estimate.winning or state.target is None:
        return texts("why_nothing")
    features = f" {texts('and')} ".join(texts(f"feature_{f}") for f in estimate.winning)
    return texts("why_features", features=features, count=estimate.num_assists)


def sureness(state: ConsoleState) -> float | None:
    """How sure the robot is, 0..1, SURE_FROM and more when it goes on alone; None before it can be."""
    estimate = state.estimate
    if estimate is None or state.target is None or state.phase not in (Phase.ASSIST, Phase.EXECUTE, Phase.DONE):
        return None
    share = estimate.confidence / state.threshold if state.threshold > 0 else 1.0
    if state.confident:
        above = (estimate.confidence - state.threshold) / (1.0 - state.threshold) if state.threshold < 1.0 else 1.0
        return SURE_FROM + (1.0 - SURE_FROM) * min(max(above, 0.0), 1.0)
    # Thresholds may be small: the square root shows that something was gained. Never past the mark while not sure.
    return min(SURE_FROM * math.sqrt(max(share, 0.0)), 0.97 * SURE_FROM)


SURE_FROM = 0.75  # of the bar


def sure_words(state: ConsoleState, level: float | None) -> str:
    """The name of the text for how sure it is; ``level`` as ``sureness`` has it."""
    if level is None:
        thinking = state.phase is Phase.ASSIST and state.target is not None
        return "sure_over" if state.phase is Phase.ABORTED else "sure_thinking" if thinking else "sure_unknown"
    return "sure_sure" if level >= SURE_FROM else "sure_nearly" if level >= 0.66 * SURE_FROM else "sure_hardly"
