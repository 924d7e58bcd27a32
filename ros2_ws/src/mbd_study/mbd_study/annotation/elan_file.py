"""ELAN's annotation files (.eaf), written and read; times in whole milliseconds, as ELAN has them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mbd_model.errors import MbdError
from pympi.Elan import Eaf

from mbd_study.annotation.intervals import Interval


class AnnotationError(MbdError):
    """An annotation file that cannot be used, or annotations that cannot be compared."""


def write_eaf(path: Path, intervals: Sequence[Interval], empty: Sequence[str] = ()) -> None:
    """Write intervals as tiers.

    Args:
        path: of the file.
        intervals: not overlapping within a tier.
        empty: names of more tiers, for those who annotate.

    Raises:
        AnnotationError: the file exists or cannot be written, an interval is shorter than a millisecond or before 0.
    """
    if path.exists():
        raise AnnotationError(f"{path} exists already and is not overwritten; choose another --out")
    eaf = Eaf(author="mbd_study")
    for tier in dict.fromkeys((*(i.tier for i in intervals), *empty)):
        eaf.add_tier(tier)
    # pympi starts with a tier of its own, of which nothing is known here.
    eaf.remove_tier("default")
    for one in intervals:
        start, end = round(1000 * one.start), round(1000 * one.end)
        if start < 0 or end <= start:
            raise AnnotationError(
                f"tier {one.tier} has {one.label!r} from {start} to {end} ms; expected 0 <= from < to"
            )
        eaf.add_annotation(one.tier, start, end, one.label)
    try:
        eaf.to_file(path)
    except OSError as error:
        raise AnnotationError(f"{path} cannot be written: {error.strerror}; choose another --out") from error


def read_eaf(path: Path) -> tuple[Interval, ...]:
    """The aligned annotations of a file, tier by tier, in order of time.

    Args:
        path: of the file.

    Raises:
        AnnotationError: it is no file of ELAN's.
    """
    try:
        eaf = Eaf(str(path), suppress_version_warning=True)
        found = [
            Interval(tier, start / 1000, end / 1000, label or "")
            for tier in eaf.get_tier_names()
            for start, end, label, *_ in sorted(eaf.get_annotation_data_for_tier(tier))
        ]
    except OSError as error:
        raise AnnotationError(f"{path} cannot be read: {error.strerror}; give a file of ELAN's (.eaf)") from error
    except Exception as error:  # pympi raises Exception itself, and KeyError, for what is no file of ELAN's
        raise AnnotationError(f"{path} is no file of ELAN's (.eaf), or damaged: {error}") from error
    return tuple(found)
