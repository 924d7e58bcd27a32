"""The pages get the newest picture, and the one each scene was observed in."""

from __future__ import annotations

import cv2
import numpy as np
from mbd_console.pictures import MEMORY, PictureStore
from mbd_model.objects import Role


def plain(red: int, green: int = 0, blue: int = 0) -> np.ndarray:
    return np.full((48, 64, 3), (red, green, blue), np.uint8)


def color_of(store: PictureStore, name: str) -> np.ndarray:
    _, data = store.jpeg(name)
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)[24, 32, ::-1].astype(int)


def test_colours_come_out_as_they_came_in():
    store = PictureStore()
    store.add(1.0, plain(200, 100, 20))
    assert np.abs(color_of(store, "live") - (200, 100, 20)).max() < 6


def test_a_scene_keeps_the_frame_it_was_observed_in_whatever_comes_later():
    store = PictureStore()
    for k in range(5):
        store.add(float(k), plain(50 * k))
    store.keep(Role.TARGET, 2.1)
    for k in range(2 * MEMORY):
        store.add(5.0 + k, plain(255))
    assert abs(color_of(store, "target")[0] - 100) < 6
    assert abs(color_of(store, "live")[0] - 255) < 6


def test_a_scene_nobody_saw_has_no_picture_rather_than_an_older_one():
    store = PictureStore()
    store.add(1.0, plain(10))
    store.keep(Role.SOURCE, 1.0)
    store.keep(Role.SOURCE, 50.0)
    assert store.jpeg("source") is None
    assert store.version("source") == 0


def test_the_version_changes_exactly_with_the_picture():
    store = PictureStore()
    assert store.version("live") == 0
    store.add(1.0, plain(1))
    first = store.jpeg("live")
    assert store.jpeg("live") is first
    store.add(2.0, plain(2))
    assert store.version("live") > first[0]


def test_an_unknown_name_has_no_picture():
    assert PictureStore().jpeg("../etc/passwd") is None
