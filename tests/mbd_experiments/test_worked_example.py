"""The example of docs/mapping.md, number by number."""

from __future__ import annotations

import dataclasses
import math
import re
from pathlib import Path

import pytest
from mbd_experiments.public_study.examples import EXAMPLES, by_hand
from mbd_experiments.public_study.explain import main
from mbd_mapping.config import OWN_THRESHOLD, MappingConfig
from mbd_mapping.inference import STRATEGIES, compare, infer
from mbd_mapping.parameters import MAPPING
from mbd_mapping.similarity import HUE, HUE_SHIFT, SIZE
from mbd_model.estimate import Feature

DOCS = Path(__file__).resolve().parents[2] / "docs" / "mapping.md"
CAB = {"red": "C", "green": "A", "blue": "B"}
BCA = {"red": "B", "green": "C", "blue": "A"}


def test_the_similarities_are_those_of_the_page() -> None:
    """Every entry of the two tables, by the formula written out and by the product."""
    task, target = by_hand().task, by_hand().target
    layers, _ = compare(task.source, target, MappingConfig()).at(())
    page = DOCS.read_text(encoding="utf-8")
    hue = {d: math.exp(-(d**2) / (2 * (0.34 * 360) ** 2)) for d in (10, 110, 130)}
    size = {r: math.exp(-((r - 1) ** 2) / (2 * (0.34 * 4) ** 2)) for r in (1, 2, 4, 0.5, 0.25)}
    assert layers[HUE, 0].tolist() == pytest.approx([hue[110], hue[130], hue[10]])
    assert layers[SIZE, 0].tolist() == pytest.approx([size[4], size[1], size[2]])
    assert layers[SIZE, 2].tolist() == pytest.approx([size[1], size[0.25], size[0.5]])
    for value in (*hue.values(), *size.values(), *layers[HUE].ravel(), *layers[SIZE].ravel()):
        assert f"{value:.4f}" in page


def test_the_rule_asks_then_goes_on() -> None:
    """Size wins by 0.0033; after red→C hue shift wins over size by 0.1007."""
    task, target, assists = by_hand().task, by_hand().target, by_hand().assists
    before = infer(task, target, (), MappingConfig("mbd"))
    assert before.mapping.as_dict == BCA
    assert (before.winning, before.runner_up) == ((Feature.SIZE,), (Feature.HUE,))
    assert before.confidence == pytest.approx(0.0033, abs=5e-5)
    after = infer(task, target, assists, MappingConfig("mbd"))
    assert after.mapping.as_dict == CAB
    assert (after.winning, after.runner_up) == ((Feature.HUE_SHIFT,), (Feature.SIZE,))
    assert after.confidence == pytest.approx(0.1007, abs=5e-5)
    layers, _ = compare(task.source, target, MappingConfig()).at([(0, 2)])
    assert layers[HUE_SHIFT][[0, 1, 2], [2, 0, 1]].tolist() == pytest.approx([1.0, 1.0, 1.0])
    assert all(
        f"**{value:.4f}**" in DOCS.read_text(encoding="utf-8") for value in (before.confidence, after.confidence)
    )


def test_evidence_weighs_them() -> None:
    """BCA has 0.5817 before, CAB 0.8742 after the assist."""
    task, target, assists = by_hand().task, by_hand().target, by_hand().assists
    config = MappingConfig(strategy="evidence")
    before, after = infer(task, target, (), config), infer(task, target, assists, config)
    assert before.mapping.as_dict == BCA
    assert before.confidence == pytest.approx(0.5817, abs=1e-4)
    assert after.mapping.as_dict == CAB
    assert after.confidence == pytest.approx(0.8742, abs=1e-4)
    assert all(
        f"**{value:.4f}**" in DOCS.read_text(encoding="utf-8") for value in (before.confidence, after.confidence)
    )


def test_explain_prints_it(capsys: pytest.CaptureFixture[str]) -> None:
    """The tool prints the numbers of the page."""
    assert main(["--assists", "1"]) == 0
    printed = capsys.readouterr().out
    assert "0.9967" in printed
    assert "0.1007" in printed


@pytest.mark.parametrize("name", sorted(EXAMPLES))
@pytest.mark.parametrize("strategy", sorted(STRATEGIES))
def test_every_example_is_explained(name: str, strategy: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Those whose scenes do not match one to one too; the page shows how each is called."""
    assert main(["--example", name, "--strategy", strategy]) == 0
    printed = capsys.readouterr().out
    assert EXAMPLES[name]().about in printed
    assert "its best mapping" in printed
    assert "confidence" in printed


def test_the_page_of_parameters_names_every_one_of_the_node_with_the_configs_default() -> None:
    """No parameter of the node is missing from the page, nor a default wrong."""
    page = (DOCS.parent / "topics.md").read_text(encoding="utf-8").partition("### mapping")[2].partition("### ")[0]
    own = {"threshold": OWN_THRESHOLD["evidence"], "promise": 0.0}  # ROS has no None: 0 promises nothing
    for field in dataclasses.fields(MappingConfig):
        if field.name not in {spec.name for spec in MAPPING.specs}:
            continue  # constants of the algorithms, or not a parameter yet
        default = own.get(field.name, getattr(MappingConfig(), field.name))
        assert re.search(rf"\*\*`{field.name}`\*\* \([^`]*default `{re.escape(str(default))}`", page), field.name
