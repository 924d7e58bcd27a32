"""How sessions of the simulated cell see: the perception node's parameters under the cell's files, as in a session."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mbd_perception.config import observe_config
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import ObserveConfig
from mbd_perception.parameters import PERCEPTION

# What perception is given of the cell: where the camera stands, and which part of the table is looked at.
FILES = ("camera.yaml", "workspace.yaml")


def perception_parameters(cell_config: Path) -> dict[str, Any]:
    """The perception node's parameters by name.

    Args:
        cell_config: folder of the cell's configuration with FILES.

    Raises:
        ParameterError: one of the files cannot be used.
    """
    given: dict[str, Any] = {}
    for name in FILES:
        given |= PERCEPTION.in_file(cell_config / name)
    return PERCEPTION.values(given)


def cell_perception(cell_config: Path, knowledge: Path) -> ObserveConfig:
    """How the perception node of a session in the cell sees.

    Args:
        cell_config: folder of the cell's configuration with FILES.
        knowledge: perception's knowledge base.

    Raises:
        MbdError: one of the files cannot be used.
    """
    return observe_config(perception_parameters(cell_config), load_knowledge(knowledge))
