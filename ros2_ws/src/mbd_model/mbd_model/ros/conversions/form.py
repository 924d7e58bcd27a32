"""Between forms that were filled in and mbd_msgs/FilledForm."""

from __future__ import annotations

import math

from mbd_msgs import msg as m

from mbd_model.forms.answers import FilledForm, FormAnswer
from mbd_model.forms.form import ItemKind
from mbd_model.ros.conversions.times import header, time_to_msg


def form_to_msg(value: FilledForm, session: str, phase: int, stamps: tuple[float, float]) -> m.FilledForm:
    """A form sent in.

    Args:
        value: what was answered.
        session: its name, "" when none is known.
        phase: of the session (`Phase`), 0 when none is known.
        stamps: when it was shown first and when it was sent in [s].
    """
    opened, sent = stamps
    return m.FilledForm(
        header=header(sent),
        opened=time_to_msg(opened),
        session=session,
        phase=phase,
        form=value.form,
        version=value.version,
        language=value.language,
        declined=value.declined,
        answers=[
            m.FormAnswer(
                item=a.item,
                kind=int(a.kind),
                text=a.text,
                answered=a.answered,
                value=a.value,
                shown=a.shown,
                number=a.number,
            )
            for a in value.answers
        ],
        scores=[m.FormScore(name=name, value=number) for name, number in value.scores],
    )


def form_from_msg(msg: m.FilledForm) -> FilledForm:
    """A form sent in; raises ValueError for a kind of item that there is not."""
    return FilledForm(
        form=msg.form,
        version=msg.version,
        language=msg.language,
        answers=tuple(
            FormAnswer(
                item=a.item,
                kind=ItemKind(a.kind),
                text=a.text,
                value=a.value if a.answered else "",
                shown=a.shown,
                number=float(a.number) if a.answered else math.nan,
            )
            for a in msg.answers
        ),
        scores=tuple((s.name, float(s.value)) for s in msg.scores),
        declined=bool(msg.declined),
    )
