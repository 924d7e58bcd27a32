"""Any function from a frame to labels is a segmenter; what it does wrong is said of the frame, and ends nothing."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_perception.config import observe_config
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import ObserveConfig, observe
from mbd_perception.frames.evidence import save_frame
from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.parameters import PERCEPTION
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.segmentation.workspace import Workspace
from mbd_perception.segmenters.blobs import blob_segmenter
from mbd_perception.segmenters.contract import ContractError, broken_promises, check_segmenter
from mbd_perception.segmenters.segmenter import SegmenterError, load_segmenter
from mbd_perception.segmenters.with_table import own_segmenter, table_segmenter
from mbd_perception.synthetic.render import Box, Cylinder, looking_at, render
from mbd_perception.tools import check_segmenter as command
from mbd_perception.tools import segment_frames

KNOWLEDGE = load_knowledge(Path(__file__).parents[2] / "ros2_ws/src/mbd_perception/config/knowledge.yaml")
POSE = looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05))
SOLIDS = [Box((0.6, 0.2, 0.0), (0.08, 0.08, 0.08), (200, 40, 40)), Cylinder((0.7, -0.1, 0.0), 0.04, 0.1, (40, 40, 200))]
VIEW = render(SOLIDS, POSE, np.random.default_rng(0))
TRUTH = VIEW.labels.astype(np.int32)  # 0 nothing, 1 table, then the solids: as one that segments everything sees it
BLOBS = "mbd_perception.segmenters.blobs:blob_segmenter"
OWN = "mbd_perception.segmenters.with_table:own_segmenter"


def answering(answer: Callable[[RgbdFrame], object]) -> ObserveConfig:
    """Perception with a segmenter plugged in."""
    return ObserveConfig(knowledge=KNOWLEDGE, segmenter=answer)


@pytest.mark.parametrize("factory", [own_segmenter, blob_segmenter], ids=lambda f: f.__name__)
def test_ours_keep_the_contract(factory: Callable[[], object]) -> None:
    """The default and the example are held to what everybody's is."""
    check_segmenter(factory)


def test_what_breaks_the_contract_is_named() -> None:
    """A sentence for each kind of mistake, and none for another one."""
    own, rng = own_segmenter(), np.random.default_rng(0)

    def changing(frame: RgbdFrame) -> np.ndarray:
        labels = own(frame)
        frame.depth[0, 0] += 1.0
        return labels

    wrong = {
        "shape": lambda frame: own(frame)[:-1],
        "integers": lambda frame: own(frame).astype(float),
        "label -1": lambda frame: own(frame) - 1,
        "NoneType": lambda _: None,
        "second time": lambda frame: own(frame) * int(rng.integers(1, 1000)),
        "was changed": changing,
        "no depth at all": lambda frame: own(frame) + 1,
        "no background": lambda frame: own(frame) + 1,
        "not one object": lambda frame: np.zeros(frame.depth.shape, int),
        "RuntimeError: out of memory": failing,
    }
    for word, segmenter in wrong.items():
        assert any(word in sentence for sentence in broken_promises(segmenter)), word
    with pytest.raises(ContractError, match="not one object"):
        check_segmenter(lambda: wrong["not one object"])


def failing(frame: RgbdFrame) -> np.ndarray:
    """A network that does not fit."""
    raise RuntimeError("out of memory")


@pytest.mark.parametrize("scale", [1, 1000])
def test_labels_of_another_segmenter_become_objects_of_the_table(scale: int) -> None:
    """Whatever its numbers are; table and wall, which one that segments everything labels too, are left out."""
    config = answering(lambda _: scale * TRUTH)
    seen = observe(VIEW.frame, Role.SOURCE, POSE, config)
    assert len(seen.scene.objects) == len(SOLIDS)
    for obj, solid in zip(seen.scene.objects, SOLIDS, strict=True):
        assert obj.box_center is not None
        assert np.hypot(obj.box_center[0] - solid.foot[0], obj.box_center[1] - solid.foot[1]) < 0.01
    without_pose = observe(VIEW.frame, Role.SOURCE, None, config)
    assert [o.color_name for o in without_pose.scene.objects] == [o.color_name for o in seen.scene.objects]


def test_workspace_and_sizes_hold_for_every_segmenter() -> None:
    """What reaches out of the workspace is left out and counted; what is smaller than the smallest object is none."""
    near = table_segmenter(lambda _: TRUTH, SegmentationConfig(workspace=Workspace(y=(0.05, 0.5))))
    found = near.find(VIEW.frame, POSE)
    assert (found.count, found.left_out) == (1, 1)
    speck = np.zeros_like(TRUTH)
    speck[np.nonzero(TRUTH == 2)[0][:5], np.nonzero(TRUTH == 2)[1][:5]] = 1
    assert table_segmenter(lambda _: speck, SegmentationConfig()).find(VIEW.frame, POSE).count == 0


def test_ours_is_what_is_used_by_default() -> None:
    """The parameter's default is our own, and named as a factory it gives the same."""
    default = observe_config(PERCEPTION.values({"camera_pose": "table"}), KNOWLEDGE)
    assert default.segmenter is None
    named = observe_config(PERCEPTION.values({"camera_pose": "table", "segmenter": OWN}), KNOWLEDGE)
    by_name, direct = observe(VIEW.frame, Role.SOURCE, None, named), segment(VIEW.frame, None, SegmentationConfig())
    np.testing.assert_array_equal(by_name.segmentation.labels, direct.labels)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("nonsense", "package.module:factory"),
        ("no_such_module:make", "cannot be imported.*PYTHONPATH"),
        ("mbd_perception.segmenters.blobs:make", "has no function make; it has .*blob_segmenter"),
        ("mbd_perception.frames.frame:make_frame", "its factory failed"),
        ("time:time", "made a float"),
        ("", "package.module:factory"),
    ],
)
def test_a_name_that_is_none_is_refused(name: str, expected: str, capsys: pytest.CaptureFixture[str]) -> None:
    """By the loader, the node's configuration and the tools, with what was expected."""
    with pytest.raises(SegmenterError, match=expected):
        load_segmenter(name)
    with pytest.raises(MbdError, match=expected):
        observe_config(PERCEPTION.values({"segmenter": name}), KNOWLEDGE)
    with pytest.raises(SystemExit) as ended:
        segment_frames.main(["frame", "--out", "out", "--segmenter", name])
    assert ended.value.code == 2
    assert "segmenter" in capsys.readouterr().err


def test_a_segmenter_that_fails_is_the_reason_of_its_frame() -> None:
    """Its own exception is the cause."""
    with pytest.raises(SegmenterError, match="RuntimeError: out of memory") as caught:
        observe(VIEW.frame, Role.SOURCE, POSE, answering(failing))
    assert isinstance(caught.value.__cause__, RuntimeError)
    with pytest.raises(SegmenterError, match="shape"):
        observe(VIEW.frame, Role.SOURCE, POSE, answering(lambda _: np.zeros((3, 3), int)))


def test_segment_goes_on_after_a_segmenter_failed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The tool takes a module of one's own, names the frame it failed on, keeps why, and does the next."""
    (tmp_path / "their_segmenter.py").write_text(
        "from mbd_perception.segmenters.blobs import blob_segmenter\n"
        "def make():\n"
        "    ours, calls = blob_segmenter(), []\n"
        "    def labels(frame):\n"
        "        calls.append(1)\n"
        "        if len(calls) == 1:\n"
        "            raise ValueError('no luck')\n"
        "        return ours(frame)\n"
        "    return labels\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        save_frame(tmp_path / name, VIEW.frame)
    arguments = [str(tmp_path / "first"), str(tmp_path / "second"), "--out", str(tmp_path / "out")]
    assert segment_frames.main([*arguments, "--segmenter", "their_segmenter:make"]) == 1
    told = capsys.readouterr()
    assert "second: 2 objects" in told.out
    assert "first: " in told.err and "no luck" in told.err
    assert "no luck" in (tmp_path / "out/first/failed_frames/frame_1/error.txt").read_text()
    assert len(json.loads((tmp_path / "out/second/objects.json").read_text())["objects"]) == 2
    assert cv2.imread(str(tmp_path / "out/second/labels.png"), cv2.IMREAD_UNCHANGED).max() == 2
    with pytest.raises(SystemExit):
        segment_frames.main([*arguments, "--segmenter", BLOBS, "--stages"])


def test_the_command_checks_a_segmenter(capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 0 for one that keeps the contract, 2 for a name that is none."""
    assert command.main([BLOBS]) == 0
    assert "0 promises broken" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        command.main(["nonsense"])


def leaving(_: RgbdFrame) -> np.ndarray:
    """One that ends the process, as a script turned module may."""
    raise SystemExit(3)


def test_one_that_ends_the_process_is_the_reason_of_its_frame() -> None:
    """It ends neither the node nor the other frames, and the check says so."""
    with pytest.raises(SegmenterError, match="SystemExit: 3"):
        observe(VIEW.frame, Role.SOURCE, POSE, answering(leaving))
    assert any("SystemExit" in sentence for sentence in broken_promises(leaving))


def test_labels_of_64_bits_are_checked() -> None:
    """Any positive number is a label, one beyond 2^63 too."""
    own = own_segmenter()

    def large(frame: RgbdFrame) -> np.ndarray:
        labels = own(frame).astype(np.uint64)
        return np.where(labels > 0, labels + np.uint64(2**63), np.uint64(0))

    assert list(broken_promises(large)) == []
