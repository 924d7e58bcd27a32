"""The layouts for RViz and Foxglove use only classes, properties and options that these programs' own sources have.

What they have is kept as lists in `viewers/`, each with the repository, commit and files that it was read from.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from mbd_msgs import msg

CONFIG = Path(__file__).resolve().parents[2] / "ros2_ws" / "src" / "mbd_bringup" / "config"
VIEWERS = Path(__file__).parent / "viewers"
RVIZ, FOXGLOVE = (json.loads((VIEWERS / f"{name}.json").read_text()) for name in ("rviz", "foxglove"))


@pytest.fixture
def rviz() -> dict[str, Any]:
    return yaml.safe_load((CONFIG / "session.rviz").read_text())


@pytest.fixture
def foxglove() -> dict[str, Any]:
    return json.loads((CONFIG / "foxglove_session.json").read_text())


def rviz_mistakes(layout: dict[str, Any]) -> Iterator[str]:
    """What RViz would not know."""
    manager = layout["Visualization Manager"]
    kinds = [("rviz_common", "panels", layout["Panels"]), ("rviz_default_plugins", "displays", manager["Displays"])]
    kinds += [("rviz_default_plugins", "tools", manager["Tools"])]
    kinds += [("rviz_default_plugins", "views", [manager["Views"]["Current"]])]
    for package, kind, parts in kinds:
        for part in parts:
            home, _, name = part["Class"].partition("/")
            if home != package or name not in RVIZ[kind]:
                yield f"class {part['Class']} among {kind}"
    for display in manager["Displays"]:
        name = display["Class"].partition("/")[2]
        known = {*RVIZ["every_display"], *RVIZ["properties"].get(name, ())}
        yield from (f"{name}: {key}" for key in display if key not in known)
        yield from (f"{name}: Topic: {key}" for key in display.get("Topic", ()) if key not in RVIZ["topic"])
        for key, value in {**display, **display.get("Topic", {})}.items():
            if key in RVIZ["options"] and value not in RVIZ["options"][key]:
                yield f"{name}: {key}: {value}"
    view = manager["Views"]["Current"]
    yield from (f"view: {key}" for key in view if key not in RVIZ["view_properties"])
    yield from (f"global: {key}" for key in manager["Global Options"] if key not in RVIZ["global_options"])


def foxglove_mistakes(layout: dict[str, Any]) -> Iterator[str]:
    """What Foxglove would not know."""
    yield from (f"layout: {key}" for key in layout if key not in FOXGLOVE["layout"])
    for panel, config in layout["configById"].items():
        kind = panel.partition("!")[0]
        if kind not in FOXGLOVE["panels"]:
            yield f"panel {panel}"
            continue
        known = {*FOXGLOVE["every_panel"], *FOXGLOVE["config"].get(kind, ())}
        yield from (f"{panel}: {key}" for key in config if key not in known)
        for part in ("cameraState", "scene", "imageMode"):
            yield from (f"{panel}: {part}: {k}" for k in config.get(part, ()) if k not in FOXGLOVE["within"][part])
        for path in config.get("paths", ()):
            yield from (f"{panel}: path: {k}" for k in path if k not in FOXGLOVE["within"][f"{kind} path"])
        for layer in config.get("layers", {}).values():
            known = FOXGLOVE["within"].get(layer["layerId"], ())
            yield from (f"{panel}: layer: {key}" for key in layer if key not in known)
        for part in (config, *config.get("paths", ()), *config.get("layers", {}).values()):
            for key, value in part.items():
                if key in FOXGLOVE["options"] and value not in FOXGLOVE["options"][key]:
                    yield f"{panel}: {key}: {value}"


def test_rviz_knows_every_class_property_and_option_of_the_layout(rviz: dict[str, Any]):
    assert list(rviz_mistakes(rviz)) == []


def test_foxglove_knows_every_panel_key_and_option_of_the_layout(foxglove: dict[str, Any]):
    assert list(foxglove_mistakes(foxglove)) == []


def test_planted_mistakes_are_found(rviz: dict[str, Any], foxglove: dict[str, Any]):
    displays = rviz["Visualization Manager"]["Displays"]
    displays[0]["Class"] = "rviz_default_plugins/Grids"
    displays[1]["Topic"]["Reliability Policy"] = "best_effort"
    displays[2]["Colour"] = 1
    assert len(list(rviz_mistakes(rviz))) >= 3
    foxglove["configById"]["Plots!x"] = {}
    foxglove["configById"]["Plot!confidence"]["title"] = "x"
    foxglove["configById"]["StateTransitions!phase"]["paths"][0]["timestampMethod"] = "now"
    assert len(list(foxglove_mistakes(foxglove))) == 3


def test_each_path_of_foxglove_is_a_field_of_the_message_on_its_topic(foxglove: dict[str, Any]):
    types = {
        "/mapping/estimate": msg.MappingEstimate,
        "/interaction/state": msg.SessionState,
        "/interaction/prompt": msg.Prompt,
        "/interaction/replies": msg.WizardReply,
    }
    configs = foxglove["configById"].values()
    paths = [p["value"] for config in configs for p in config.get("paths", ())]
    paths += [config["topicPath"] for config in configs if "topicPath" in config]
    assert len(paths) >= 6
    for path in paths:
        topic, *fields = path.split(".")
        message = types[topic]()
        for field in fields:
            assert field in message.get_fields_and_field_types(), path
            message = getattr(message, field)


def test_rviz_asks_for_no_more_than_the_publishers_offer(rviz: dict[str, Any]):
    """A latched topic is asked for as such, a sensor's as best effort: else nothing would come, or too late."""
    for display in rviz["Visualization Manager"]["Displays"]:
        topic = display.get("Topic")
        if topic is None:
            continue
        latched = topic["Value"].endswith("/markers")
        wanted = ("Transient Local", "Reliable") if latched else ("Volatile", "Best Effort")
        assert (topic["Durability Policy"], topic["Reliability Policy"]) == wanted, topic["Value"]
