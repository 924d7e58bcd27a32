"""Tables 4 and 5: what the tasks were, and how consistent the participants."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby

from mbd_experiments.csv_table import CsvRow
from mbd_experiments.user_study.cases import Case
from mbd_experiments.user_study.consistency import assists_consistent, demonstration_consistent
from mbd_experiments.user_study.predictions import SessionPrediction, by_session


def by_task(cases: Iterable[Case]) -> list[tuple[str, str, list[Case]]]:
    """(origin, task, its cases), in the order of `read_cases`."""
    groups = groupby(cases, key=lambda c: (str(c.origin), c.task_name))
    return [(origin, task, list(group)) for (origin, task), group in groups]


def usual(values: Iterable[int]) -> int:
    """The value met most often, of several the smallest."""
    counts = Counter(values)
    return min(counts, key=lambda v: (-counts[v], v))


def solutions(acceptable: Mapping[str, frozenset[str]], used: Sequence[str]) -> int:
    """How many ways there are to give each object used an acceptable target of its own."""

    def count(rest: Sequence[str], taken: frozenset[str]) -> int:
        if not rest:
            return 1
        return sum(count(rest[1:], taken | {t}) for t in acceptable.get(rest[0], frozenset()) - taken)

    return count(used, frozenset())


def table4(cases: Sequence[Case]) -> list[CsvRow]:
    """One row a task: objects, steps, solutions, affordances and properties of its objects."""
    rows: list[CsvRow] = []
    for origin, task, group in by_task(cases):
        objects = [o for c in group for o in (*c.task.source.objects, *c.target.objects)]
        rows.append(
            {
                "origin": origin,
                "task": task,
                "sessions": len(group),
                "source_objects": usual(len(c.task.source.objects) for c in group),
                "target_objects": usual(len(c.target.objects) for c in group),
                # Those of the script: a participant may take more or fewer.
                "steps": usual(2 * len(c.script) or len(c.task.steps) for c in group),
                "solutions": usual(solutions(c.acceptable, _objects_of(c)) for c in group),
                "affordances": " ".join(sorted(frozenset().union(*(o.affordances for o in objects)))),
                "properties": " ".join(sorted(frozenset().union(*(o.properties for o in objects)))),
            }
        )
    return rows


def _objects_of(case: Case) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for pair in case.script for name in pair)) or case.task.used_objects


def table5(cases: Sequence[Case], predictions: Sequence[SessionPrediction]) -> list[CsvRow]:
    """One row a task and strategy: consistent sessions, and in how many of those all assists give the mapping."""
    last = {(o, s, name): group[-1] for (o, s, _, name), group in by_session(predictions).items()}
    strategies = tuple(dict.fromkeys(p.strategy for p in predictions))
    rows: list[CsvRow] = []
    for origin, task, group in by_task(cases):
        shown = {c.name for c in group if demonstration_consistent(c)}
        consistent = {c.name for c in group if assists_consistent(c)}
        known = all(c.script for c in group)
        for strategy in strategies:
            found = sum(last[origin, strategy, name].correct for name in shown & consistent)
            rows.append(
                {
                    "origin": origin,
                    "task": task,
                    "strategy": strategy,
                    "sessions": len(group),
                    "consistent_demonstrations": len(shown) if known else "not known",
                    "consistent_assists": len(consistent) if known else "not known",
                    "both_consistent": len(shown & consistent) if known else "not known",
                    "mapped_of_both": found if known else "not known",
                }
            )
    return rows
