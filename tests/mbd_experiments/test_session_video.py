"""A film of a cell shows what passes, in a file small enough, and nothing else is written."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from mbd_cell.cell import Cell
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.physics.camera_pose import CELL_CAMERA
from mbd_experiments.session_video.film import Film
from mbd_experiments.session_video.video_command import main
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from PIL import Image

CONFIG = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_cell" / "config"


@pytest.fixture(scope="module")
def film() -> Film:
    """Two seconds of an arm that tucks itself in, then another table."""
    cell = Cell(load_scenes(CONFIG / "sorting.yaml"), 2, CELL_CAMERA)
    taken = Film(cell, 2.0, lambda: ("two tables", "one after the other"))
    for role in (Role.SOURCE, Role.TARGET):
        cell.lay(role, 2)
        for _ in range(100):
            cell.tick()
            taken.tick()
    taken.close()
    return taken


def test_a_film_has_as_many_images_as_time_passed_and_the_second_table_looks_different(film: Film):
    assert len(film.images) == 10
    assert np.abs(film.images[0].astype(int) - film.images[-1]).max() > 100


def test_a_gif_holds_every_image_that_differs_and_an_mp4_all_of_them(film: Film, tmp_path: Path):
    assert film.write(tmp_path / "f.gif") == (tmp_path / "f.gif").stat().st_size < 1_000_000
    with Image.open(tmp_path / "f.gif") as gif:
        assert gif.n_frames >= 2 and gif.size == film.images[0].shape[1::-1]
    film.write(tmp_path / "f.mp4")
    movie = cv2.VideoCapture(str(tmp_path / "f.mp4"))
    assert movie.get(cv2.CAP_PROP_FRAME_COUNT) >= len(film.images)


@pytest.mark.parametrize("name", ["f.txt", "f"])
def test_a_film_of_another_kind_is_refused_before_anything_is_filmed(film: Film, tmp_path: Path, name: str, capsys):
    with pytest.raises(MbdError, match=r"gif or \.mp4"):
        film.write(tmp_path / name)
    with pytest.raises(SystemExit):
        main([str(tmp_path / name)])
    assert ".gif or .mp4" in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_where_nothing_can_be_written_one_sentence_says_so(film: Film, tmp_path: Path):
    with pytest.raises(MbdError, match="give another place"):
        film.write(tmp_path / "missing" / "f.gif")
