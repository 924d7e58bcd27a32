"""The markers node's parameters."""

from __future__ import annotations

from mbd_model.parameters import ParameterSpec, ParameterTable

MARKERS = ParameterTable(
    "markers",
    (
        ParameterSpec(
            "source_aside",
            (0.0, 1.1, 0.0),
            "Where the source scene is drawn once the target scene is there: x, y, z from its place in the base frame.",
            "m",
        ),
    ),
)
