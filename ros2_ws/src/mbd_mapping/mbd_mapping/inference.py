"""The one entry of the mapping: names in, names out; used by the node and by offline replay alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from mbd_model.assists import Assist, Denial
from mbd_model.errors import MbdError
from mbd_model.estimate import Feature, Mapping, MappingEstimate
from mbd_model.objects import Scene
from mbd_model.task import Task

from mbd_mapping.config import MappingConfig
from mbd_mapping.evidence import infer_evidence
from mbd_mapping.mbd import infer_mbd
from mbd_mapping.similarity import Comparison
from mbd_mapping.stopping.promise_table import CALIBRATION
from mbd_mapping.strategy import UNMAPPED, Pair, QuestionAnswers, Reading, Strategy
from mbd_mapping.tables import ObjectTable

STRATEGIES: dict[str, Strategy] = {"mbd": infer_mbd, "evidence": infer_evidence}
FEATURES = tuple(Feature)
SAID_FROM = 0.01  # smaller doubts about a step are weighed without a word


class UnknownStrategyError(MbdError):
    """No strategy has that name."""


def infer(
    task: Task,
    target: Scene,
    assists: Sequence[Assist],
    config: MappingConfig,
    denials: Sequence[Denial] = (),
) -> MappingEstimate:
    """Map the objects of the task's source scene to those of the target scene (paper sec. 4.3).

    Every object of both scenes takes part, also those the task never uses: they show which target objects are taken.

    Args:
        task: the demonstrated task with its source scene, n objects.
        target: the scene it is carried over to, m objects; n and m may differ, then min(n, m) objects are mapped.
        assists: all assists in force, oldest first. One of an unknown object is left out with a warning.
        config: strategy and constants.
        denials: every "no" in force. "mbd", which knows none, leaves them out with a warning.

    Returns:
        The complete result; the same arguments always give the same one.

    Raises:
        UnknownStrategyError: ``config.strategy`` is not a key of STRATEGIES.
    """
    if config.strategy not in STRATEGIES:
        raise UnknownStrategyError(f"no mapping strategy '{config.strategy}'; there are {sorted(STRATEGIES)}")
    source = task.source
    reading = read_assists(assists, source.ids, target.ids)
    asked = {row for row, _ in reading.pairs}
    askable = [row for row in map(source.ids.index, task.used_objects) if row not in asked]
    answers, unused = read_answers(assists, denials, source.ids, target.ids, config.strategy)
    doubts, doubtful = read_doubts(task, assists, target.ids, config.strategy)
    answers = replace(answers, doubts=doubts)
    result = STRATEGIES[config.strategy](compare(source, target, config), reading.pairs, askable, answers)
    left = len(set(task.used_objects)) - sum(source.ids[row] in set(task.used_objects) for row in asked)

    def named(columns: Sequence[int], score: float) -> Mapping:
        pairs = ((source.ids[r], target.ids[c]) for r, c in enumerate(columns) if c != UNMAPPED)
        return Mapping(tuple(pairs), score)

    def read(reading: Reading | None) -> Mapping:
        return named(reading.columns, reading.score) if reading else named(result.columns, result.score)

    return MappingEstimate(
        strategy=config.strategy,
        mapping=named(result.columns, result.score),
        confidence=result.confidence,
        winning=tuple(FEATURES[k] for k in result.winning),
        runner_up=tuple(FEATURES[k] for k in result.runner_up),
        alternatives=tuple(named(columns, score) for columns, score in result.alternatives),
        ties=result.ties,
        num_assists=len(assists),
        warnings=reading.warnings + unused + doubtful,
        next_question="" if result.next_row == UNMAPPED else source.ids[result.next_row],
        information_gain=result.information_gain,
        best_guess=read(result.best_guess),
        obeying=read(result.obeying),
        doubted=_last_with(assists, source, target, result.doubted),
        doubt=result.doubt,
        question_kind=result.question_kind,
        question_targets=tuple(target.ids[c] for c in result.question_columns),
        threshold=stop_at(config, max(0, left)),
    )


def stop_at(config: MappingConfig, left: int) -> float:
    """The confidence from which the robot goes on alone, with ``left`` objects nobody has told about yet.

    Under a promise that depends on how many are left; more than 1 says never while a promise so high cannot be kept.
    """
    return config.stop_at if config.promise is None else CALIBRATION.threshold(config.promise, left)


def _last_with(assists: Sequence[Assist], source: Scene, target: Scene, pair: Pair | None) -> Assist | None:
    """The latest assist that says so."""
    if pair is None:
        return None
    wanted = source.ids[pair[0]], target.ids[pair[1]]
    return next(a for a in reversed(assists) if (a.source_id, a.target_id) == wanted)


def read_answers(
    assists: Sequence[Assist],
    denials: Sequence[Denial],
    source_ids: Sequence[str],
    target_ids: Sequence[str],
    strategy: str,
) -> tuple[QuestionAnswers, tuple[str, ...]]:
    """What is confirmed and denied as rows and columns, and a sentence about each denial that is left out."""

    def known(claim: Assist | Denial) -> bool:
        return claim.source_id in source_ids and claim.target_id in target_ids

    def pair(claim: Assist | Denial) -> Pair:
        return source_ids.index(claim.source_id), target_ids.index(claim.target_id)

    warnings = [
        f"denial ({d.source_id} is not {d.target_id}) is ignored: there is no such object"
        for d in denials
        if not known(d)
    ]
    if strategy == "mbd" and denials:
        warnings.append(f"{len(denials)} denials are ignored: strategy 'mbd' weighs assists only; use 'evidence'")
    confirmed = _still_confirmed([(pair(a), a.confirmed) for a in assists if known(a)])
    return QuestionAnswers(confirmed, tuple(pair(d) for d in denials if known(d))), tuple(warnings)


def _still_confirmed(said: Sequence[tuple[Pair, bool]]) -> frozenset[Pair]:
    """Of (pair, whether it was confirmed), oldest first: what no later assist has contradicted."""
    confirmed: set[Pair] = set()
    for (row, column), is_confirmed in said:
        confirmed = {(r, c) for r, c in confirmed if (r == row) == (c == column)}
        if is_confirmed:
            confirmed.add((row, column))
    return frozenset(confirmed)


def read_doubts(
    task: Task, assists: Sequence[Assist], target_ids: Sequence[str], strategy: str
) -> tuple[tuple[tuple[Pair, float], ...], tuple[str, ...]]:
    """How doubtful each assist's demonstrated step is, as rows and columns, and a sentence about each that matters."""
    source_ids = task.source.ids
    doubts: dict[Pair, float] = {}
    warnings: list[str] = []
    for assist in assists:
        step = task.steps[assist.step_index] if 0 <= assist.step_index < len(task.steps) else None
        if step is None or step.primary_object != assist.source_id or assist.target_id not in target_ids:
            continue
        pair = source_ids.index(assist.source_id), target_ids.index(assist.target_id)
        if not step.doubt:
            doubts[pair] = 0.0
        elif not assist.confirmed and doubts.get(pair, 1.0) > step.doubt:
            doubts[pair] = step.doubt
            if step.doubt >= SAID_FROM:
                weighs = "counts in full with strategy 'mbd'" if strategy == "mbd" else "counts less"
                warnings.append(
                    f"step {step.index + 1} may have been about {step.runner_up} instead of {step.primary_object} "
                    f"({step.doubt:.0%}): the assist for it {weighs}"
                )
    return tuple((pair, doubt) for pair, doubt in doubts.items() if doubt), tuple(warnings)


@lru_cache(maxsize=8)
def compare(source: Scene, target: Scene, config: MappingConfig) -> Comparison:
    """The two scenes, compared; kept, as only the assists change during a session."""
    return Comparison.of(ObjectTable.of(source.objects), ObjectTable.of(target.objects), config)


@dataclass(frozen=True)
class AssistReading:
    """Assists as rows and columns.

    Attributes:
        pairs: (source row, target column) of every assist whose objects exist, oldest first.
        warnings: what was wrong with the others, and which contradict an earlier one; a sentence each.
    """

    pairs: tuple[Pair, ...]
    warnings: tuple[str, ...]


def read_assists(assists: Sequence[Assist], source_ids: Sequence[str], target_ids: Sequence[str]) -> AssistReading:
    """Look the objects up; complain about what does not exist or contradicts an earlier assist."""
    pairs: list[Pair] = []
    warnings: list[str] = []
    target_of: dict[str, str] = {}
    source_of: dict[str, str] = {}
    for number, assist in enumerate(assists, start=1):
        source, target = assist.source_id, assist.target_id
        claim = f"assist {number} ({source} -> {target})"
        if source not in source_ids:
            warnings.append(f"{claim} is ignored: the source scene has no '{source}', only {sorted(source_ids)}")
            continue
        if target not in target_ids:
            warnings.append(f"{claim} is ignored: the target scene has no '{target}', only {sorted(target_ids)}")
            continue
        if target_of.get(source, target) != target:
            warnings.append(f"{claim} contradicts an earlier assist: {source} -> {target_of[source]}")
        elif source_of.get(target, source) != source:
            warnings.append(f"{claim} contradicts an earlier assist: {source_of[target]} -> {target}")
        else:
            target_of[source], source_of[target] = target, source
        pairs.append((source_ids.index(source), target_ids.index(target)))
    return AssistReading(tuple(pairs), tuple(warnings))
