"""``picture BAG --out FILE.png``: source and target scene side by side, with the mapping between them."""

from __future__ import annotations

from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.session.command_line import bag_parser, read_session, run_tool
from mbd_bag.session.recorded_session import Recorded, RecordedSession
from mbd_bag.session.scene_images import camera_of, image_at
from mbd_bag.storage.bag import Bag
from mbd_model.camera.view import CameraView
from mbd_model.times import to_nanoseconds
from rich.console import Console

from mbd_study.figures.mapping_figure import MappingArrow, ScenePanel, draw_mapping
from mbd_study.recompute.reevaluation import input_of
from mbd_study.tables.correctness import answers_of


def panels_of(bag: Bag, session: RecordedSession, camera: CameraView | None = None) -> tuple[ScenePanel, ScenePanel]:
    """Source and target panel of a session; seen from above unless the bag has picture, camera and pose for both.

    Raises:
        BagError: the session never saw both scenes.
    """
    if not session.target_scenes or not (session.source_scenes or session.tasks):
        lacks = "target" if session.source_scenes else "source"
        raise BagError(f"session '{session.name}' has no {lacks} scene, so there is no mapping to draw")
    target = session.target_scenes[-1]
    if session.source_scenes:
        source = session.source_scenes[-1]
    else:
        task = session.tasks[-1]
        source = Recorded(task.value.source, to_nanoseconds(task.value.source.stamp), task.log_time)
    camera = camera or camera_of(bag)
    images = [image_at(bag, s.stamp, s.log_time) for s in (source, target)] if camera is not None else [None, None]
    if any(image is None for image in images):
        camera = None
    titles = ("source: demonstrated with these", "target: carried over to these")
    first, second = (
        ScenePanel(title, s.value, image if camera is not None else None, camera)
        for title, s, image in zip(titles, (source, target), images, strict=True)
    )
    return first, second


def arrows_of(session: RecordedSession) -> tuple[MappingArrow, ...]:
    """The last mapping of a session; () when there is none."""
    if not session.estimates:
        return ()
    recorded, inputs = session.estimates[-1]
    assists = input_of(session.assists, inputs.assists_stamp, recorded.log_time) or ()
    assisted = {(a.source_id, a.target_id) for a in assists}
    answers = answers_of(session)
    used = set(session.tasks[-1].value.used_objects) if session.tasks else set()
    return tuple(
        MappingArrow(
            source,
            target,
            (source, target) in assisted,
            answers is not None and source in used and not answers.is_right(source, target),
        )
        for source, target in recorded.value.mapping.pairs
    )


def draw_session(bag: Bag, session: RecordedSession, out: Path, camera: CameraView | None = None) -> None:
    """Draw a session's last mapping.

    Args:
        bag: of the session, for its pictures.
        session: as read from it.
        out: picture file to write (PNG).
        camera: in place of the recorded one.

    Raises:
        BagError: the session never saw both scenes.
    """
    task = session.facts.get("task") or session.name
    subtitle = "no mapping was made"
    if session.estimates:
        recorded, inputs = session.estimates[-1]
        estimate = recorded.value
        assists = "1 assist" if estimate.num_assists == 1 else f"{estimate.num_assists} assists"
        sure = "sure enough to go on alone" if inputs.confident else "not sure enough to go on alone"
        features = " and ".join(f.replace("_", " ") for f in estimate.winning) or "no feature"
        subtitle = f"after {assists}, by {features}, confidence {estimate.confidence:.3f}: {sure}"
    draw_mapping(
        panels_of(bag, session, camera), arrows_of(session), f"{task.replace('_', ' ').capitalize()}", subtitle, out
    )


_KINDS = (".png", ".jpg", ".pdf", ".svg")


def _tool() -> int:
    parser = bag_parser(__doc__ or "")
    parser.add_argument("--out", type=Path, required=True, help="picture file to write (.png)")
    arguments = parser.parse_args()
    if arguments.out.suffix.lower() not in _KINDS:
        parser.error(f"--out: '{arguments.out.name}' is no picture; expected a name ending in {', '.join(_KINDS)}")
    console = Console()
    bag, session = read_session(arguments.bag, console)
    draw_session(bag, session, arguments.out)
    console.print(f"wrote {arguments.out}", highlight=False, soft_wrap=True)
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when the bag cannot be used."""
    run_tool("picture", _tool)
