"""`ros2 run mbd_experiments study_data DIR`: replay the public user-study data through a strategy.

Writes one row per session and number of assists, and a summary: correct at k, within k, and by threshold (Figures 9
and 10).
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from mbd_mapping.config import MappingConfig, MissingHue
from mbd_mapping.inference import STRATEGIES, infer, read_assists
from mbd_mapping.strategy import first_assists
from mbd_model.command_line.parser import CommandParser
from mbd_model.errors import MbdError

from mbd_experiments.public_study.study_folder import StudySession, read_what_can_be_read

TASKS = {"t0": "stacking", "t1": "sorting", "t2": "lunch"}
LAST_COLUMN = 4
THRESHOLDS = {
    "mbd": (0.0, 0.005, 0.01, 0.015, 0.02, 0.05, 0.1, 0.25),
    "evidence": (0.0, 0.2, 0.3, 1.0 / 3.0, 0.4, 0.5, 0.7, 0.9),
}


@dataclass(frozen=True)
class Row:
    """One inference on a session; the fields are the columns of the CSV."""

    session: str
    assists: int
    correct: int
    confidence: float
    feature: str
    hypotheses: int
    tied: int
    mapping: str


def replay(session: StudySession, config: MappingConfig) -> list[Row]:
    """Estimates after 0, 1, ... assists; "mbd" stops where the assists leave one mapping, as the study did."""
    rows = []
    source, target = session.task.source, session.target
    for k in range(len(session.assists) + 1):
        assists = session.assists[:k]
        estimate = infer(session.task, target, assists, config)
        given = len(first_assists(read_assists(assists, source.ids, target.ids).pairs))
        sizes = len(source.ids) - given, len(target.ids) - given
        hypotheses = math.perm(max(sizes), min(sizes))
        rows.append(
            Row(
                session.name,
                k,
                int(session.solved_by(estimate.mapping.as_dict)),
                estimate.confidence,
                "+".join(estimate.winning),
                hypotheses,
                estimate.ties,
                " ".join(sorted(f"{s}:{t}" for s, t in estimate.mapping.pairs)),
            )
        )
        if hypotheses == 1 and config.strategy == "mbd":
            break
    return rows


def both_readings(sessions: Sequence[StudySession], config: MappingConfig) -> list[str]:
    """Lines: right at k by the best guess, and by the mapping that obeys every assist; nobody answers what is asked."""
    counts: dict[str, list[int]] = {"best guess": [], "obeying": [], "asks about an assist": []}
    for k in range(LAST_COLUMN + 1):
        found = [(s, infer(s.task, s.target, s.assists[:k], config)) for s in sessions]
        counts["best guess"].append(sum(s.solved_by(e.best_guess.as_dict) for s, e in found))
        counts["obeying"].append(sum(s.solved_by(e.obeying.as_dict) for s, e in found))
        counts["asks about an assist"].append(sum(e.doubted is not None for _, e in found))
    ends = [(s, infer(s.task, s.target, s.assists, config)) for s in sessions]
    counts["best guess"].append(sum(s.solved_by(e.best_guess.as_dict) for s, e in ends))
    counts["obeying"].append(sum(s.solved_by(e.obeying.as_dict) for s, e in ends))
    counts["asks about an assist"].append(sum(e.doubted is not None for _, e in ends))
    return [f"{name:20} at {' '.join(map(str, c[:-1]))}   all assists {c[-1]}" for name, c in counts.items()]


def stop(rows: Sequence[Row], threshold: float) -> Row:
    """The row at which the robot goes on alone: the first of enough confidence, else the last."""
    return next((row for row in rows if row.confidence >= threshold), rows[-1])


def at_assists(rows: Sequence[Row], k: int) -> Row:
    """The row after k assists, or the last."""
    return rows[min(k, len(rows) - 1)]


def summary(replays: Sequence[Sequence[Row]], config: MappingConfig) -> list[str]:
    """Lines: correct at k and within k by task, all given, and by threshold."""
    columns = range(LAST_COLUMN + 1)
    lines = [
        f"strategy {config.strategy}, {len(replays)} sessions",
        "correct      at k = " + " ".join(map(str, columns)),
    ]
    for suffix, name in TASKS.items():
        own = [rows for rows in replays if rows[0].session.endswith(f"_{suffix}")]
        at = [sum(at_assists(rows, k).correct for rows in own) for k in columns]
        within = [sum(any(row.correct for row in rows[: k + 1]) for rows in own) for k in columns]
        lines.append(f"{name:12} at     {' '.join(map(str, at))}   within {' '.join(map(str, within))}   of {len(own)}")
    lines.append(f"all assists given: {sum(rows[-1].correct for rows in replays)}/{len(replays)} correct")
    for threshold in sorted({*THRESHOLDS[config.strategy], config.stop_at}):
        stops = [stop(rows, threshold) for rows in replays]
        note = "  (its own)" if threshold == config.stop_at else ""
        lines.append(
            f"threshold {threshold:.3f}: {sum(row.correct for row in stops)}/{len(stops)} correct, "
            f"{sum(row.assists for row in stops) / len(stops):.2f} assists on average{note}"
        )
    return lines


def write_rows(rows: Sequence[Row], path: Path) -> None:
    """The CSV; confidence with six decimals."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([field.name for field in fields(Row)])
        for row in rows:
            values = [getattr(row, field.name) for field in fields(Row)]
            writer.writerow([f"{v:.6f}" if isinstance(v, float) else v for v in values])


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; 0 when every session was replayed, 1 when some were left out, which it names."""
    parser = CommandParser(prog="study_data", description=__doc__)
    parser.add_argument("folder", type=Path, help="the public folder data/hri17")
    parser.add_argument("--strategy", choices=sorted(STRATEGIES), default="mbd")
    parser.add_argument("--as-recorded", action="store_true", help="take the missing hue -1000 as a number")
    parser.add_argument(
        "--similarity-noise",
        type=float,
        default=MappingConfig().similarity_noise,
        help="of evidence; 0: exact features",
    )
    parser.add_argument("--csv", type=Path, default=Path("study_data.csv"), help="where the rows go")
    options = parser.parse_args(arguments)
    hue = MissingHue.AS_RECORDED if options.as_recorded else MissingHue.GREY
    try:
        config = MappingConfig(strategy=options.strategy, missing_hue=hue, similarity_noise=options.similarity_noise)
        reading = read_what_can_be_read(options.folder)
    except MbdError as error:
        sys.stderr.write(f"study_data: {error}\n")
        return 1
    replays = [replay(session, config) for session in reading.sessions]
    try:
        write_rows([row for rows in replays for row in rows], options.csv)
    except OSError as error:
        sys.stderr.write(f"study_data: cannot write {options.csv}: {error.strerror}; choose another file with --csv\n")
        return 1
    if replays:
        lines = summary(replays, config) + both_readings(reading.sessions, config)
        sys.stdout.write("\n".join(lines) + f"\nrows in {options.csv}\n")
    for problem in reading.problems:
        sys.stderr.write(f"study_data: {problem}\n")
    return 1 if reading.problems else 0


if __name__ == "__main__":
    raise SystemExit(main())
