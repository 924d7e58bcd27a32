"""Parameters that a bag does not state, taken from parameter files: where the camera stood is never assumed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from mbd_bag.errors import BagError
from mbd_bag.formats.bounded_yaml import bounded_yaml
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.session.session_facts import parameter_facts, parameters_of
from mbd_demonstration.parameters import DEMONSTRATION
from mbd_model.parameters import ParameterTable
from mbd_perception.parameters import PERCEPTION

DEFAULTS = Path("defaults")
_TABLES = (PERCEPTION, DEMONSTRATION)
_EXPECTED = "expected sections such as '/**' with ros__parameters"


def facts_of_files(files: Sequence[Path]) -> dict[str, str]:
    """Facts of a session as ROS parameter files state them, later files over earlier ones.

    Args:
        files: as nodes take them, for example ``camera.yaml``; DEFAULTS stands for the default of every parameter.

    Raises:
        MbdError: a file is none, or holds a value that its parameter does not take.
    """
    facts: dict[str, str] = {}
    if DEFAULTS in files:
        for table in _TABLES:
            facts |= parameter_facts(f"/{table.node}", _plain({spec.name: spec.default for spec in table.specs}))
    for file in files:
        if file == DEFAULTS:
            continue
        for node, given in _by_node(file).items():
            table = next(t for t in _TABLES if t.node == node)
            table.refuse_unknown(given)
            checked = {spec.name: spec.checked(given[spec.name]) for spec in table.specs if spec.name in given}
            facts |= parameter_facts(f"/{node}", _plain(checked))
    return facts


def _plain(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: list(v) if isinstance(v, tuple) else v for name, v in values.items()}


def _by_node(file: Path) -> dict[str, dict[str, Any]]:
    """What a file gives each of our nodes; what it gives all of them goes to those that have such a parameter."""
    found: dict[str, dict[str, Any]] = {table.node: {} for table in _TABLES}
    try:
        content = bounded_yaml(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise BagError(f"{file} cannot be read ({error.strerror}); give a ROS parameter file") from error
    except ValueError as error:
        raise BagError(f"{file} is no ROS parameter file ({error}); {_EXPECTED}") from error
    try:
        for section, inner in content.items():
            values: dict[str, Any] = dict(inner["ros__parameters"])
            node = str(section).rpartition("/")[2]
            if node in found:
                found[node] |= values
            elif node == "**":
                for table in _TABLES:
                    found[table.node] |= {name: v for name, v in values.items() if name in table.names}
    except (ValueError, AttributeError, KeyError, TypeError) as error:
        raise BagError(f"{file} is no ROS parameter file; {_EXPECTED}") from error
    if not any(found.values()):
        raise BagError(f"{file} states no parameter of {' or '.join(found)}; docs/topics.md lists them")
    return found


def with_facts(session: RecordedSession, given: Mapping[str, str]) -> RecordedSession:
    """The session with these facts in place of those its bag states of the same."""
    if not given:
        return session
    names = {key.rpartition("/")[2] for key in given}
    kept = {k: v for k, v in session.facts.items() if k.rpartition("/")[2] not in names}
    return replace(session, facts=kept | dict(given))


def require_parameters(session: RecordedSession, table: ParameterTable) -> None:
    """Raises BagError when nothing states the parameters of a node.

    Args:
        session: as recorded, with what was given besides.
        table: of the node.
    """
    if not parameters_of(session.facts, table.node):
        raise BagError(
            f"the bag states no parameters of {table.node} (another program recorded it, or its metadata is lost), and "
            f"none are assumed: give those of the session, --parameters FILE (docs/topics.md lists them), or take each "
            f"one's default, --parameters defaults"
        )
