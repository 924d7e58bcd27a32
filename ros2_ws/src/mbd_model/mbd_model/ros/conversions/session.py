"""Between the dialogue's state and prompts and mbd_msgs/SessionState and Prompt."""

from __future__ import annotations

from mbd_msgs import msg as m

from mbd_model.execution_progress import Verdict
from mbd_model.ros.conversions.assist import assist_from_msg, assist_to_msg, denial_from_msg, denial_to_msg
from mbd_model.ros.conversions.times import header, time_from_msg
from mbd_model.session import Awaited, GripperWord, Phase, Prompt, PromptKind, SessionState


def prompt_to_msg(value: Prompt, stamp: float) -> m.Prompt:
    """The robot's prompt at ``stamp`` [s]."""
    return m.Prompt(
        header=header(stamp),
        kind=int(value.kind),
        text=value.text,
        step_index=value.step_index,
        source_id=value.source_id,
        target_ids=list(value.target_ids),
        source_ids=list(value.source_ids),
    )


def prompt_from_msg(msg: m.Prompt) -> Prompt:
    """The robot's prompt."""
    return Prompt(
        kind=PromptKind(msg.kind),
        text=msg.text,
        step_index=int(msg.step_index),
        source_id=msg.source_id,
        target_ids=tuple(msg.target_ids),
        source_ids=tuple(msg.source_ids),
    )


def state_to_msg(value: SessionState, stamp: float) -> m.SessionState:
    """Where the session is at ``stamp`` [s]."""
    return m.SessionState(
        header=header(stamp),
        session=value.session,
        phase=int(value.phase),
        paused=value.paused,
        step_index=value.step_index,
        assists=[assist_to_msg(a) for a in value.assists],
        num_events=value.num_events,
        detail=value.detail,
        recording=value.recording,
        awaiting=int(value.awaiting),
        denials=[denial_to_msg(d) for d in value.denials],
        skipped=list(value.skipped),
        words=[_word_to_msg(w) for w in value.words],
        verdict=int(value.verdict),
    )


def _word_to_msg(word: GripperWord) -> m.WizardGripper:
    command = m.WizardGripper.CLOSE if word.close else m.WizardGripper.OPEN
    return m.WizardGripper(header=header(word.stamp), command=command)


def _closes(msg: m.WizardGripper) -> bool:
    if msg.command not in (m.WizardGripper.OPEN, m.WizardGripper.CLOSE):
        raise ValueError(f"command {msg.command} of words is neither OPEN (1) nor CLOSE (2)")
    return bool(msg.command == m.WizardGripper.CLOSE)


def state_from_msg(msg: m.SessionState) -> SessionState:
    """Where the session is; raises ValueError for a phase, something awaited, a verdict or a gripper command there
    is not.
    """
    return SessionState(
        session=msg.session,
        phase=Phase(msg.phase),
        paused=bool(msg.paused),
        step_index=int(msg.step_index),
        assists=tuple(assist_from_msg(a) for a in msg.assists),
        num_events=int(msg.num_events),
        detail=msg.detail,
        recording=bool(msg.recording),
        awaiting=Awaited(msg.awaiting),
        denials=tuple(denial_from_msg(d) for d in msg.denials),
        skipped=tuple(int(i) for i in msg.skipped),
        words=tuple(GripperWord(time_from_msg(w.header.stamp), _closes(w)) for w in msg.words),
        verdict=Verdict(msg.verdict),
    )
