"""A dialogue that continues after its node was killed."""

from __future__ import annotations

from dataclasses import replace

from mbd_model.session import Phase, SessionState

from mbd_interaction.config import DialogueConfig
from mbd_interaction.dialogue import Dialogue


def restored(kept: SessionState, assists_stamp: int, config: DialogueConfig) -> Dialogue:
    """The dialogue of a kept state, whose assists were published under ``assists_stamp`` [ns].

    Task, target scene and estimate come again on their latched topics; until then ASSIST asks nothing. A request that
    was under way is forgotten: the wizard gives the word again. An assist that was asked about and left unconfirmed is
    asked about again.
    """
    return Dialogue(
        session=kept.session,
        phase=kept.phase,
        paused=kept.paused,
        step_index=-1 if kept.phase in (Phase.TUCK_AND_CLEAR, Phase.ASSIST) else kept.step_index,
        assists=kept.assists,
        num_events=kept.num_events,
        detail=kept.detail,
        recording=kept.recording,
        config=config,
        assists_stamp=assists_stamp,
        skipped=frozenset(kept.skipped),
        denials=kept.denials,
        words=kept.words,
        verdict=kept.verdict,
    )


def begun(session: str, config: DialogueConfig, detail: str) -> Dialogue:
    """A new session."""
    return replace(Dialogue(session, config=config), detail=detail)
