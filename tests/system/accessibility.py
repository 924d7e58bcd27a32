"""What axe-core finds wrong on a page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from console_browser import Browser

AXE = Path(__file__).resolve().parents[2] / ".venv" / "node" / "node_modules" / "axe-core" / "axe.min.js"
needs_axe = pytest.mark.skipif(not AXE.exists(), reason="needs axe-core: tools/browser gets it by npm")


def prefer(browser: Browser, scheme: str) -> None:
    """Ask pages for a "light" or "dark" scheme, as the browser's user would."""
    feature = {"name": "prefers-color-scheme", "value": scheme}
    browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})


def violations(browser: Browser) -> list[str]:
    """What axe-core finds wrong, each with the element."""
    browser.driver.execute_script(AXE.read_text())
    found: list[dict[str, Any]] = browser.driver.execute_async_script(
        "const done = arguments[arguments.length - 1]; axe.run(document).then(result => done(result.violations))"
    )
    return [f"{v['id']}: {node['html'][:120]}" for v in found for node in v["nodes"]]
