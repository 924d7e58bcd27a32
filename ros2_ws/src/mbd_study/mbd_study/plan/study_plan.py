"""``plan.yaml``: conditions, tasks, participants, how they are ordered; read and checked."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from mbd_bag.formats.bounded_yaml import bounded_yaml
from mbd_model.errors import MbdError
from mbd_model.parameters import nearest

from mbd_study.plan.orders import Order

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


class PlanError(MbdError):
    """A plan that cannot be used. The text states where in it, what was expected and what to do."""


@dataclass(frozen=True)
class StudyPlan:
    """What a study intends.

    Attributes:
        study: its name.
        seed: of every order, and of the sessions' own seeds.
        conditions: names, in the order that FIXED means.
        condition_order: of the conditions of one participant; BLOCKS: each participant meets one of them.
        tasks: names, likewise; each is done once in each condition that a participant meets.
        task_order: of the tasks within a condition; never BLOCKS.
        participants: pseudonyms, in the order they come.
        arguments: by condition, what the session is started with besides (``name:=value``).
    """

    study: str
    seed: int
    conditions: tuple[str, ...]
    condition_order: Order
    tasks: tuple[str, ...]
    task_order: Order
    participants: tuple[str, ...]
    arguments: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


_KEYS = ("study", "seed", "conditions", "condition_order", "tasks", "task_order", "participants", "arguments")
_NEEDED = ("study", "seed", "conditions", "tasks", "participants")


def read_plan(path: Path) -> StudyPlan:
    """The plan in a file.

    Args:
        path: of the YAML.

    Raises:
        PlanError: it cannot be read, or is no plan.
    """
    try:
        text = path.read_text(encoding="utf-8")
        value = bounded_yaml(text)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no text"
        raise PlanError(f"the plan {path} cannot be read ({reason}); give the YAML file of a study") from error
    except ValueError as error:
        raise PlanError(f"the plan {path} is no YAML: {error}") from error
    try:
        _refuse_keys_given_twice(text)
        return plan_of(value)
    except PlanError as error:
        raise PlanError(f"{path}: {error}") from error


def _refuse_keys_given_twice(text: str) -> None:
    """YAML takes the last of two equal keys without a word, which here would change the study."""
    node = yaml.compose(text, yaml.SafeLoader)
    keys = [key.value for key, _ in node.value] if isinstance(node, yaml.MappingNode) else []
    for place, key in enumerate(keys):
        if key in keys[:place]:
            raise PlanError(f"the key {key!r} is given twice; keep one")


def plan_of(value: Any) -> StudyPlan:
    """The plan that a YAML value states; raises PlanError."""
    if not isinstance(value, dict):
        raise PlanError(f"expected keys and values ({', '.join(_KEYS)}), found {_shown(value)}")
    for key in value:
        if key not in _KEYS:
            near = nearest(str(key), _KEYS)
            hint = f"; did you mean {near!r}?" if near else f"; expected one of {', '.join(_KEYS)}"
            raise PlanError(f"unknown key {key!r}{hint}")
    missing = [key for key in _NEEDED if key not in value]
    if missing:
        raise PlanError(f"the key {missing[0]!r} is missing; a plan needs {', '.join(_NEEDED)}")
    seed = value["seed"]
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise PlanError(f"seed is {_shown(seed)}; expected a whole number from 0")
    conditions = _names(value["conditions"], "conditions")
    task_order = _order(value.get("task_order", "williams"), "task_order")
    if task_order is Order.BLOCKS:
        raise PlanError("task_order is 'blocks', which gives each participant one task only; list it as a condition")
    return StudyPlan(
        study=_name(value["study"], "study"),
        seed=seed,
        conditions=conditions,
        condition_order=_order(value.get("condition_order", "williams"), "condition_order"),
        tasks=_names(value["tasks"], "tasks"),
        task_order=task_order,
        participants=_participants(value["participants"]),
        arguments=_arguments(value.get("arguments"), conditions),
    )


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _name(value: Any, where: str) -> str:
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise PlanError(
            f"{where} has {_shown(value)}; expected a name of letters, digits, '_', '-', '.' (in quotes if it is a "
            f"number), since folders are named by it"
        )
    return value


def _names(value: Any, where: str) -> tuple[str, ...]:
    if not isinstance(value, list) or not value:
        raise PlanError(f"{where} is {_shown(value)}; expected a list of names, e.g. [sorting, stacking]")
    names = tuple(_name(item, where) for item in value)
    twice = [name for k, name in enumerate(names) if name in names[:k]]
    if twice:
        raise PlanError(f"{where} names {twice[0]!r} twice; expected each name once")
    return names


def _order(value: Any, where: str) -> Order:
    try:
        return Order(value)
    except ValueError:
        near = nearest(str(value), list(Order))
        hint = f"; did you mean {str(near)!r}?" if near else ""
        raise PlanError(f"{where} is {_shown(value)}; expected one of {', '.join(Order)}{hint}") from None


def _participants(value: Any) -> tuple[str, ...]:
    """A list of pseudonyms, or their number: p01, p02, ..."""
    if isinstance(value, int) and not isinstance(value, bool):
        if not 1 <= value <= 9999:
            raise PlanError(f"participants is {value}; expected 1 to 9999, or a list of pseudonyms")
        width = max(2, len(str(value)))
        return tuple(f"p{number:0{width}d}" for number in range(1, value + 1))
    return _names(value, "participants")


def _arguments(value: Any, conditions: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    if value is None:
        return {}
    if not isinstance(value, dict):
        raise PlanError(f"arguments is {_shown(value)}; expected a list of name:=value by condition")
    for condition, words in value.items():
        if condition not in conditions:
            near = nearest(str(condition), conditions)
            hint = f"; did you mean {near!r}?" if near else f"; expected one of {', '.join(conditions)}"
            raise PlanError(f"arguments has {_shown(condition)}, which is no condition{hint}")
        if not isinstance(words, list) or not all(isinstance(w, str) and ":=" in w for w in words):
            raise PlanError(f"arguments of {condition} is {_shown(words)}; expected a list of 'name:=value'")
    return {condition: tuple(words) for condition, words in value.items()}
