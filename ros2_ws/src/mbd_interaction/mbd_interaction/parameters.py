"""The interaction node's parameters, and the config they make."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from mbd_model.estimate import QuestionKind
from mbd_model.parameters import ParameterError, ParameterSpec, ParameterTable

from mbd_interaction.config import DialogueConfig, QuestionOrder

INTERACTION = ParameterTable(
    "interaction",
    (
        ParameterSpec("session", "session", "Name of the session; also of its bag."),
        ParameterSpec("state_dir", "", "Folder that keeps the session over a restart; empty: not kept."),
        ParameterSpec(
            "question_order",
            DialogueConfig.question_order.value,
            "Which step is asked first: the next of the task, or the one that would teach most.",
            choices=tuple(QuestionOrder),
        ),
        ParameterSpec(
            "question_kinds",
            tuple(kind.value for kind in DialogueConfig.question_kinds),
            "How a step may be asked about, where the mapping learns most that way: what_next (always), is_this_it, "
            "which_of_two.",
        ),
        ParameterSpec(
            "point_reach", DialogueConfig.point_reach, "A pointed place means an object this near.", "m", (0.0, 5.0)
        ),
        ParameterSpec(
            "doubt_asked",
            DialogueConfig.doubt_asked,
            "A demonstrated step is asked about when its runner-up was meant with this probability; above 0.5: none.",
            range=(0.001, 1.0),
        ),
        ParameterSpec(
            "execute",
            DialogueConfig.execute,
            "Wait in EXECUTE for the execution node to do the task.",
            formerly=("carry_on",),
        ),
        ParameterSpec(
            "service_patience", 3.0, "Until a service that is not there is reported missing.", "s", range=(0.0, 600.0)
        ),
        ParameterSpec(
            "answer_patience", 30.0, "Until a service that does not answer is given up.", "s", range=(0.1, 600.0)
        ),
        ParameterSpec("estimate_patience", 10.0, "Until a missing estimate is asked about.", "s", range=(0.1, 600.0)),
    ),
)


ASKABLE = (QuestionKind.WHAT_NEXT, QuestionKind.IS_THIS_IT, QuestionKind.WHICH_OF_TWO)


def question_kinds(names: Iterable[str]) -> tuple[QuestionKind, ...]:
    """The kinds of question of those names; raises ParameterError for one there is not."""
    wrong = [name for name in names if name not in ASKABLE]
    if wrong:
        raise ParameterError(f"parameter question_kinds has {wrong}; expected some of {[str(k) for k in ASKABLE]}")
    return tuple(QuestionKind(name) for name in names)


def dialogue_config(values: Mapping[str, Any]) -> DialogueConfig:
    """How the dialogue behaves, from values of the parameters of INTERACTION by name.

    Raises:
        ParameterError: a kind of question there is not.
    """
    return DialogueConfig(
        point_reach=values["point_reach"],
        question_order=QuestionOrder(values["question_order"]),
        execute=values["execute"],
        question_kinds=question_kinds(values["question_kinds"]),
        doubt_asked=values["doubt_asked"],
    )
