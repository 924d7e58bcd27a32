"""``check_segmenter package.module:factory``: whether a segmenter keeps what docs/perception.md promises of one."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from mbd_model.command_line.parser import CommandParser

from mbd_perception.segmenters.contract import broken_promises, contract_frames
from mbd_perception.segmenters.segmenter import SegmenterError, load_segmenter


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; 0 when every promise is kept, 1 when not, 2 for a wrong call."""
    parser = CommandParser(prog="check_segmenter", description="Check a segmenter against the contract.")
    parser.add_argument("segmenter", metavar="PACKAGE.MODULE:FACTORY", help="as `segment --segmenter` takes it")
    name = parser.parse_args(arguments).segmenter
    try:
        broken = list(broken_promises(load_segmenter(name)))
    except SegmenterError as error:
        parser.error(str(error))
    for sentence in broken:
        sys.stdout.write(f"broken: {sentence}\n")
    sys.stdout.write(f"{name}: {len(broken)} promises broken on {len(contract_frames())} frames\n")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
