"""The console's parameters. The token that opens it to the network is none: recorders keep parameters in bags."""

from __future__ import annotations

from mbd_model.camera.parameters import CAMERA_ORIENTATION, CAMERA_POSITION
from mbd_model.parameters import ParameterSpec, ParameterTable

CONSOLE = ParameterTable(
    "console",
    (
        ParameterSpec("host", "", "Address to listen on; empty: this machine only, or all with a token."),
        ParameterSpec("port", 8080, "TCP port of the web page.", range=(1, 65535)),
        ParameterSpec("language", "en", "Of the pages that ask for none: en, de.", choices=("en", "de")),
        ParameterSpec(
            "forms", (), "Forms of the study, each NAME or NAME@phase; NAME: a shipped form, or a YAML file."
        ),
        ParameterSpec(
            "state_dir", "", "Folder that keeps clock, forms and photographs over a restart; empty: not kept."
        ),
        ParameterSpec(
            "room_dir",
            "",
            "Folder beside the session's bag, for sound and picture of the room; empty: the room cannot be recorded.",
        ),
        CAMERA_POSITION,
        CAMERA_ORIENTATION,
    ),
)
