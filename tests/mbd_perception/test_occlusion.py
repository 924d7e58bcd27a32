"""What stands behind something stays one thing, and two things on both sides of it stay two."""

from __future__ import annotations

import numpy as np
import pytest
from mbd_experiments.perception_training.rejoin_pairs import room_pairs
from mbd_experiments.perception_training.train_rejoin import fitted, main
from mbd_model.errors import MbdError
from mbd_perception.segmentation.joining.occlusion import PieceFeatures
from mbd_perception.segmentation.joining.rejoining import RejoinConfig
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.synthetic.casting import Solid
from mbd_perception.synthetic.render import Box, Cylinder, looking_at, render
from mbd_perception.synthetic.rooms import Kind

SLANTED = looking_at((-0.1, 0.0, 0.6), (0.65, 0.0, 0.05))
RED, GREEN, BLUE = (200, 40, 40), (40, 160, 60), (40, 60, 190)
POLE = Cylinder((0.55, 0.0, 0.0), 0.02, 0.3, GREEN)


def count(*solids: Solid) -> int:
    """How many objects are found."""
    return segment(render(list(solids), SLANTED, np.random.default_rng(3)).frame, None, SegmentationConfig()).count


def test_box_behind_a_pole() -> None:
    """A box that a pole cuts in two is one thing."""
    assert count(POLE, Box((0.75, 0.0, 0.0), (0.08, 0.3, 0.1), RED)) == 2


def test_two_boxes_behind_a_pole() -> None:
    """Boxes of other colours and heights on both sides of a pole are two things."""
    assert (
        count(POLE, Box((0.75, 0.1, 0.0), (0.08, 0.16, 0.1), RED), Box((0.8, -0.1, 0.0), (0.1, 0.16, 0.05), BLUE)) == 3
    )


GOOD = PieceFeatures(misfit=0.0, hidden=1.0, table=0.0, breadth=1.0, gap=0.3, chroma=0.0, top=0.0, size=1.0)


@pytest.mark.parametrize(
    "worse", [{"misfit": 4.0}, {"hidden": 0.5}, {"table": 0.5}, {"breadth": 0.2}, {"chroma": 50.0}, {"top": 0.8}]
)
def test_what_speaks_against(worse: dict[str, float]) -> None:
    """A worse fit, less cover, a table between, other breadth, colour or top each speak against one thing."""
    config = RejoinConfig()
    assert config.log_odds(GOOD) > 0
    assert config.log_odds(PieceFeatures(**{**vars(GOOD), **worse})) < config.log_odds(GOOD)


def test_fitted_model_separates() -> None:
    """A model fitted to separable pairs is right on them, and swapping the classes turns its weights round."""
    rng = np.random.default_rng(0)
    same = np.arange(40) % 4 == 0
    rows = rng.normal(0.0, 0.3, (40, 5)) - np.where(same, 1.0, -1.0)[:, None]
    b = fitted(rows, same, 1e-3)
    assert ((rows @ b[1:] + b[0] > 0) == same).all()
    np.testing.assert_allclose(fitted(rows, ~same, 1e-3), -b, atol=0.05)


def test_one_class() -> None:
    """Pairs of one class only teach nothing: refused."""
    with pytest.raises(MbdError, match="something stands before a thing"):
        fitted(np.zeros((3, 5)), np.zeros(3, dtype=bool), 1e-3)


def test_rooms_differ() -> None:
    """The pairs of rendered rooms are reproducible."""
    assert list(room_pairs((Kind.MANY,), 2)) == list(room_pairs((Kind.MANY,), 2))


def test_missing_truth(tmp_path: object, capsys: pytest.CaptureFixture[str]) -> None:
    """A folder without a frame is named."""
    with pytest.raises(SystemExit):
        main([str(tmp_path), "--rooms", "0"])
    assert "is missing" in capsys.readouterr().err
