"""How the simulated study sees: the perception node's parameters under the cell's own files, as in a session."""

from __future__ import annotations

from pathlib import Path
from typing import Any

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
