"""Where an arm's description lies."""

from __future__ import annotations

from pathlib import Path

MODELS = Path(__file__).parent / "models"


def model_file(model: str) -> Path:
    """The file of a model: of a name of ours in ``MODELS``, or the path of a URDF or MJCF; it need not be there."""
    return Path(model).expanduser() if "/" in model else MODELS / f"{model}.xml"
