"""The knowledge base states what an object is, or that it does not know."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from mbd_perception.features.knowledge import KnowledgeBase, KnowledgeError, load_knowledge, parse_knowledge

FILE = Path(__file__).parents[2] / "ros2_ws/src/mbd_perception/config/knowledge.yaml"
BASE = load_knowledge(FILE)
# One object of each class as the cell lays it (docs/object_catalogue.md): (width, depth, height) [m], hue [deg].
CATALOGUE = [
    ("cup", (0.080, 0.080, 0.100), 0.0),
    ("cup", (0.039, 0.039, 0.049), 60.0),
    ("cup", (0.075, 0.075, 0.094), 75.0),
    ("bowl", (0.110, 0.110, 0.046), 6.0),
    ("bowl", (0.132, 0.132, 0.056), 225.0),
    ("utensil", (0.150, 0.019, 0.016), 40.0),
    ("utensil", (0.023, 0.165, 0.018), 250.0),
    ("block", (0.084, 0.052, 0.039), 100.0),
    ("block", (0.038, 0.060, 0.028), 280.0),
    ("block", (0.084 * 1.12, 0.052 * 1.12, 0.039 * 1.12), 228.0),
    ("carton", (0.055, 0.055, 0.110), 210.0),
    ("carton", (0.060, 0.060, 0.120), 30.0),
    ("lunch_box", (0.250, 0.170, 0.055), 185.0),
    ("lunch_box", (0.230, 0.155, 0.050), 330.0),
    ("fruit", (0.062, 0.058, 0.050), 75.0),
    ("fruit", (0.074, 0.074, 0.058), 95.0),
    ("chips", (0.095, 0.045, 0.090), 15.0),
    ("chips", (0.088, 0.042, 0.084), 280.0),
]
error = st.floats(-0.0035, 0.0035)


@pytest.mark.parametrize(("name", "size", "hue"), CATALOGUE)
@given(dw=error, dd=error, dh=error)
def test_catalogue(name: str, size: tuple[float, float, float], hue: float, *, dw: float, dd: float, dh: float) -> None:
    """Every object of the cell is recognised; measured with errors of 3.5 mm it is at worst unknown."""
    assert BASE.match(size, hue).name == name
    width, depth, height = size
    assert BASE.match((width + dw, depth + dd, height + dh), hue).name in (name, "unknown")


@given(st.tuples(*[st.floats(0.005, 0.5)] * 3), st.none() | st.floats(0, 359.9))
def test_score(size: tuple[float, float, float], hue: float | None) -> None:
    """The score is a share, and swapping width and depth changes nothing."""
    match = BASE.match(size, hue)
    assert 0 <= match.score <= 1
    assert BASE.match((size[1], size[0], size[2]), hue) == match


@given(st.floats(0.3, 2.0))
def test_too_large(side: float) -> None:
    """A thing far larger than any class is unknown."""
    assert BASE.match((side, side, side), 10.0).name == "unknown"


def one_class(**changes: object) -> dict[str, object]:
    """A knowledge base of one good class with some keys changed; a key set to None is left out."""
    document = {"long": [0.1, 0.2], "short": [0.1, 0.2], "height": [0.1, 0.2]} | changes
    return {"classes": {"ball": {k: v for k, v in document.items() if v is not None}}}


def test_ambiguous() -> None:
    """Two classes that fit equally well are unknown rather than a guess."""
    document = one_class()
    document["classes"]["cube"] = document["classes"]["ball"]  # type: ignore[index]  # a plain dict
    assert parse_knowledge(document, "x").match((0.15, 0.15, 0.15), None).name == "unknown"


@pytest.mark.parametrize(("hue", "known"), [(350.0, True), (5.0, True), (20.0, True), (180.0, False), (None, False)])
def test_hue_wraps(hue: float | None, known: bool) -> None:
    """A hue range from 340 to 20 goes through red, and a grey object does not fit it."""
    base = parse_knowledge(one_class(hue=[340, 20]), "x")
    assert (base.match((0.15, 0.15, 0.15), hue).name == "ball") is known


@pytest.mark.parametrize(
    ("document", "words"),
    [
        (None, "expected a mapping"),
        ({}, "'classes'"),
        ({"classes": {}}, "'classes'"),
        ({"clases": {}}, "'clases' is not known"),
        ({"classes": {"ball": 3}}, "classes.ball"),
        ({"classes": {"unknown": {}}}, "classes.unknown"),
        (one_class(long=None), "classes.ball.long' is missing"),
        (one_class(long=[0.2, 0.1]), "classes.ball.long"),
        (one_class(short=[-0.1, 0.1]), "classes.ball.short"),
        (one_class(height=0.1), "classes.ball.height"),
        (one_class(height=["tall", 1]), "classes.ball.height"),
        (one_class(heigth=[0.1, 0.2]), "classes.ball.heigth' is not known"),
        (one_class(hue=[0, 400]), "classes.ball.hue"),
        (one_class(affordances="fillable"), "classes.ball.affordances"),
        (one_class() | {"hue_tolerance": 0}, "hue_tolerance"),
        (one_class() | {"min_score": "high"}, "min_score"),
    ],
)
def test_refused(document: object, words: str) -> None:
    """A wrong knowledge base is refused with the name of the file and of the key."""
    with pytest.raises(KnowledgeError, match=words) as caught:
        parse_knowledge(document, "kb.yaml")
    assert str(caught.value).startswith("kb.yaml: ")


def test_files(tmp_path: Path) -> None:
    """A file that is missing or no YAML is refused by name; a written one reads back."""
    with pytest.raises(KnowledgeError, match=r"missing\.yaml"):
        load_knowledge(tmp_path / "missing.yaml")
    broken = tmp_path / "broken.yaml"
    broken.write_text("classes: [", encoding="utf-8")
    with pytest.raises(KnowledgeError, match=r"broken\.yaml"):
        load_knowledge(broken)
    good = tmp_path / "good.yaml"
    good.write_text(yaml.safe_dump(one_class()), encoding="utf-8")
    assert isinstance(load_knowledge(good), KnowledgeBase)
