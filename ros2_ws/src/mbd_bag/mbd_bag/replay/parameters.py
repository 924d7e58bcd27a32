"""The replay node's parameters: its command's options, which may change while it runs."""

from __future__ import annotations

from mbd_model.parameters import ParameterSpec, ParameterTable

REPLAY = ParameterTable(
    "replay",
    (
        ParameterSpec("rate", 1.0, "Recorded seconds a second.", range=(0.01, 1000.0), read_only=False),
        ParameterSpec("loop", False, "Start over at the end.", read_only=False),
        ParameterSpec("paused", False, "Publish nothing.", read_only=False),
    ),
)
