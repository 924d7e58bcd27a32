"""The session's entry point: it answers Ctrl-C from the first moment, while what it needs is still being imported."""

from __future__ import annotations

import sys
from importlib import import_module


def main() -> None:
    """Lead a session."""
    try:
        import_module("mbd_bringup.ros.lead_session").main()
    except KeyboardInterrupt:
        sys.stderr.write("session: interrupted before anything was started\n")
        sys.exit(130)
