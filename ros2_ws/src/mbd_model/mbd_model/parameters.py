"""A node's parameters, declared once: for the node, for docs/topics.md and for a computation from a bag.

A table is a plain value: the node declares it to ROS (`ros.parameters`), the page of parameters prints it, and what a
bag or a parameter file holds is read by the same table, so that the three cannot differ.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from mbd_model.errors import MbdError

Value = bool | int | float | str | tuple[float, ...] | tuple[str, ...]

# Every ROS node has these, whatever its table states.
ROS_NAMES = ("use_sim_time", "start_type_description_service")
ROS_PREFIX = "qos_overrides."
# How alike a misspelt name must be to the one it was meant to be, 0..1.
ALIKE = 0.5


class ParameterError(MbdError):
    """A parameter that is not there, or a value it does not take."""


class ParameterTypeError(ParameterError):
    """A value of another type than the parameter's."""


@dataclass(frozen=True)
class ParameterSpec:
    """One parameter.

    Attributes:
        name: its name.
        default: value when it is not given; its type is the parameter's. Numbers in a tuple have a fixed count, that of
            the default; texts in a tuple may be any number.
        description: what it means.
        unit: of its number or numbers; "" for none.
        range: (lowest, highest) number, both allowed, highest may be infinite; None when not limited.
        choices: allowed words; () when not limited.
        read_only: False when it may change while the node runs.
        required: True when the node does not start without it.
        formerly: names it had in earlier versions, which old bags hold.
        derived: the default when values of other parameters decide it, from those; ``default`` is what it gives for
            their defaults.
    """

    name: str
    default: Value
    description: str
    unit: str = ""
    range: tuple[float, float] | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = True
    required: bool = False
    formerly: tuple[str, ...] = ()
    derived: Callable[[Mapping[str, Any]], Value] | None = None

    @property
    def kind(self) -> str:
        """Its type as people write it."""
        if isinstance(self.default, tuple):
            numbers = bool(self.default) and isinstance(self.default[0], float)
            return f"{len(self.default)} numbers" if numbers else "list of texts"
        names = {bool: "true or false", int: "integer", float: "number", str: "text"}
        return names[type(self.default)]

    @property
    def allowed(self) -> str:
        """Which values it takes, as people write it; "" when any of its type."""
        if self.choices:
            return f"one of: {', '.join(self.choices)}"
        if self.range is None:
            return ""
        low, high = self.range
        if math.isinf(high):
            return f"{low:g} or more"
        return f"{int(low)} to {int(high)}" if isinstance(self.default, int) else f"{low:g} to {high:g}"

    def checked(self, value: object) -> Value:
        """The value as the parameter's type: integers as numbers where those are asked, lists as tuples.

        Raises:
            ParameterTypeError: it is of another type.
            ParameterError: it is out of range, none of the choices, or not finite (NaN passes where it is the default).
        """
        made = self._typed(value)
        for number in made if isinstance(made, tuple) else (made,):
            if isinstance(number, float) and not math.isfinite(number) and not self._undecided(number):
                raise ParameterError(f"parameter {self.name} is {_shown(made)}; expected finite numbers")
            if self.range is not None and isinstance(number, int | float) and not self._undecided(number):
                low, high = self.range
                if not low <= number <= high:
                    unit = f" [{self.unit}]" if self.unit else ""
                    raise ParameterError(
                        f"parameter {self.name} is {_shown(made)}; expected {self.kind}, {self.allowed}{unit}"
                    )
        if self.choices and made not in self.choices:
            raise ParameterError(f"parameter {self.name} is {_shown(made)}; expected {self.allowed}")
        return made

    def _undecided(self, number: float) -> bool:
        """NaN where that is the default: for example of a level to be learned."""
        return math.isnan(number) and isinstance(self.default, float) and math.isnan(self.default)

    def _typed(self, value: object) -> Value:
        default = self.default
        if isinstance(default, tuple):
            inner = type(default[0]) if default else str
            made = _tuple_of(inner, value)
            if made is not None and (inner is str or len(made) == len(default)):
                return made
        elif isinstance(default, float) and isinstance(value, int) and not isinstance(value, bool):
            return float(value)
        elif type(value) is type(default) and isinstance(value, bool | int | float | str):
            return value
        raise ParameterTypeError(f"parameter {self.name} is {_shown(value)}; expected {self.kind}: {self.description}")


def _tuple_of(inner: type, value: object) -> tuple[float, ...] | tuple[str, ...] | None:
    """A sequence of numbers or texts as a tuple; None when it is none."""
    if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
        return None
    items = tuple(value)
    if inner is str:
        return items if all(isinstance(v, str) for v in items) else None
    if any(isinstance(v, bool) or not isinstance(v, int | float) for v in items):
        return None
    return tuple(float(v) for v in items)


def _shown(value: object) -> str:
    return f"'{value}'" if isinstance(value, str) else str(list(value) if isinstance(value, tuple) else value)


@dataclass(frozen=True)
class ParameterTable:
    """All parameters of one node.

    Attributes:
        node: its name.
        specs: in the order in which they are declared; a derived default comes after what decides it.
    """

    node: str
    specs: tuple[ParameterSpec, ...]

    def __getitem__(self, name: str) -> ParameterSpec:
        """The parameter of that name; raises ParameterError with the nearest right one."""
        self.refuse_unknown((name,))
        return next(spec for spec in self.specs if spec.name == name)

    @property
    def names(self) -> tuple[str, ...]:
        """Of all parameters."""
        return tuple(spec.name for spec in self.specs)

    def refuse_unknown(self, given: Iterable[str]) -> None:
        """Raises ParameterError when a given name is neither in the table nor ROS's own, with the nearest right one."""
        wrong = [n for n in given if n not in self.names and n not in ROS_NAMES and not n.startswith(ROS_PREFIX)]
        if wrong:
            raise ParameterError("; ".join(self._unknown(name) for name in wrong))

    def _unknown(self, name: str) -> str:
        renamed = next((s.name for s in self.specs if name in s.formerly), "")
        if renamed:
            return f"parameter '{name}' of {self.node} is called '{renamed}' now"
        near = nearest(name, self.names)
        advice = f"did you mean '{near}'?" if near else f"it has: {', '.join(self.names)}"
        return f"{self.node} has no parameter '{name}'; {advice}"

    def values(self, given: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Every parameter's value by name: what is given, else the default.

        Raises:
            ParameterError: a name that is not in the table, or a value that the parameter does not take.
        """
        overrides = dict(given or {})
        self.refuse_unknown(overrides)
        made: dict[str, Any] = {}
        for spec in self.specs:
            default = spec.derived(made) if spec.derived is not None else spec.default
            made[spec.name] = spec.checked(overrides[spec.name]) if spec.name in overrides else default
        return made

    def recorded(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """What a bag holds of this node's parameters, by today's names; those of another version are left out.

        Raises:
            ParameterError: a value that the parameter does not take.
        """
        found: dict[str, Any] = {}
        for spec in self.specs:
            name = next((n for n in (spec.name, *spec.formerly) if n in values), None)
            if name is not None:
                found[spec.name] = spec.checked(values[name])
        return found

    def in_file(self, path: Path) -> dict[str, Any]:
        """What a ROS parameter file gives this node, by name.

        Raises:
            ParameterError: it cannot be read, names a parameter that the node has not, or gives it what it takes not.
        """
        found: dict[str, Any] = {}
        expected = "expected sections such as '/**' with ros__parameters"
        try:
            content = yaml.safe_load(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise ParameterError(f"{path} cannot be read ({error.strerror}); give a ROS parameter file") from error
        except (UnicodeDecodeError, yaml.YAMLError, RecursionError) as error:
            raise ParameterError(f"{path} is no ROS parameter file, as it is no YAML; {expected}") from error
        if not isinstance(content, dict):
            raise ParameterError(f"{path} is no ROS parameter file; {expected}, found {str(content)[:60]!r}")
        for section, inner in content.items():
            if str(section).rpartition("/")[2] in ("**", self.node):
                values = inner.get("ros__parameters") if isinstance(inner, dict) else None
                if not isinstance(values, dict):
                    raise ParameterError(f"{path} is no ROS parameter file: {section} has no ros__parameters")
                found |= values
        try:
            self.refuse_unknown(found)
            return {spec.name: spec.checked(found[spec.name]) for spec in self.specs if spec.name in found}
        except ParameterError as error:
            raise ParameterError(f"{path}: {error}") from error


def nearest(name: str, names: Iterable[str]) -> str:
    """Which of the names a misspelt one was most likely meant to be; "" when it is like none of them."""
    near = get_close_matches(name, list(names), n=1, cutoff=ALIKE)
    return near[0] if near else ""
