"""How long one inference takes, beside enumeration of all mappings in the same run; how it grows; what memory it takes.

Limits are held against the least of several runs in CPU time: other programs of the machine do not count.
"""

from __future__ import annotations

import math
import sys
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mbd_mapping.config import FeatureSpace, MappingConfig
from mbd_mapping.mbd import competing_sets, infer_mbd
from mbd_mapping.similarity import Comparison
from mbd_mapping.strategy import Pair
from mbd_mapping.synthetic import random_table

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "mbd_mapping"))
from mapping_oracle import enumerate_all

ASSISTS: list[Pair] = [(0, 1)]


def compared(size: int, config: MappingConfig, *, variety: int = 0, seed: int = 0) -> Comparison:
    """Two random scenes of that size; ``variety`` > 0 makes objects alike, so that many mappings tie."""
    rng = np.random.default_rng([seed, size])
    return Comparison.of(random_table(rng, size, "s", variety), random_table(rng, size, "t", variety), config)


def cpu_ms(call: Callable[[], object], rounds: int) -> float:
    """Least CPU time of a call [ms]."""
    times = []
    for _ in range(rounds):
        begun = time.process_time()
        call()
        times.append(time.process_time() - begun)
    return 1e3 * min(times)


@pytest.mark.parametrize(
    ("size", "space", "limit_ms"),
    [
        (7, FeatureSpace.SINGLE, 1.0),
        (7, FeatureSpace.ALL, 10.0),
        (20, FeatureSpace.SINGLE, 5.0),
        (20, FeatureSpace.ALL, 5.0),
        (100, FeatureSpace.SINGLE, 150.0),
        (100, FeatureSpace.ALL, 150.0),
    ],
)
def test_one_inference(benchmark: Callable[..., object], size: int, space: FeatureSpace, limit_ms: float) -> None:
    """One inference after an assist, E computed already but for its shifts, stays within its limit."""
    comparison = compared(size, MappingConfig(feature_space=space))
    benchmark(lambda: infer_mbd(comparison, ASSISTS, ()))
    least = min(
        cpu_ms(lambda k=k: infer_mbd(compared(size, comparison.config, seed=k), ASSISTS, ()), 5) for k in range(3)
    )
    benchmark.extra_info["cpu_ms_with_E"] = least
    assert least <= limit_ms


@pytest.mark.parametrize("space", list(FeatureSpace))
def test_many_ties(benchmark: Callable[..., object], space: FeatureSpace) -> None:
    """A hundred objects of which many are alike, with a hundred ties listed, stay within the limit too."""
    comparison = compared(100, MappingConfig(feature_space=space), variety=3)
    benchmark.pedantic(lambda: infer_mbd(comparison, ASSISTS, ()), rounds=3)
    assert infer_mbd(comparison, ASSISTS, ()).ties == comparison.config.max_ties
    assert cpu_ms(lambda: infer_mbd(comparison, ASSISTS, ()), 3) <= 150.0


def test_memory(benchmark: Callable[..., object]) -> None:
    """A hundred objects and all 127 sets take at most 100 MB."""
    config = MappingConfig(feature_space=FeatureSpace.ALL)
    tracemalloc.start()
    benchmark.pedantic(lambda: infer_mbd(compared(100, config), ASSISTS, ()), rounds=1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    benchmark.extra_info["peak_MB"] = peak / 1e6
    assert peak <= 100e6


def test_growth(benchmark: Callable[..., object], capsys: pytest.CaptureFixture[str]) -> None:
    """Beside enumeration the rule gains with every object, and it grows no faster than the cube of their number."""
    lines = [
        "",
        f"{'n':>4} {'sets':>7} {'mappings':>12} {'enumeration':>12} {'mbd':>10} {'ratio':>8}   (CPU, least of 5)",
    ]
    ratios: dict[FeatureSpace, list[float]] = {}
    least: dict[FeatureSpace, dict[int, float]] = {space: {} for space in FeatureSpace}
    for space in FeatureSpace:
        config = MappingConfig(feature_space=space)
        for size in (4, 5, 6, 7, 8, 10, 20, 40, 70, 100):
            comparison = compared(size, config)
            ours = cpu_ms(lambda c=comparison: infer_mbd(c, ASSISTS, ()), 5)
            least[space][size] = ours
            theirs = math.nan
            # One assist leaves (n - 1)! mappings; 127 sets of them for n = 9 would need gigabytes.
            if size <= (8 if space == FeatureSpace.SINGLE else 7):
                layers, exists = comparison.at(ASSISTS)
                members = competing_sets(comparison, ASSISTS, exists)
                theirs = cpu_ms(lambda a=layers, b=members: enumerate_all(a, b, ASSISTS), 3)
                ratios.setdefault(space, []).append(theirs / ours)
            shown = "" if math.isnan(theirs) else f"{theirs:9.2f} ms"
            ratio = "" if math.isnan(theirs) else f"{theirs / ours:7.1f}x"
            lines.append(f"{size:4} {space:>7} {math.factorial(size - 1):12.3g} {shown:>12} {ours:7.2f} ms {ratio:>8}")
    for space, times in least.items():
        sizes = [size for size in times if size >= 20]
        power = float(np.polyfit(np.log(sizes), np.log([times[s] for s in sizes]), 1)[0])
        lines.append(f"{space}: time grows as n^{power:.2f} from n = 20 to 100")
        assert power <= 3.0
    with capsys.disabled():
        sys.stdout.write("\n".join(lines) + "\n")
    assert all(found[-1] > found[0] for found in ratios.values())
    comparison = compared(20, MappingConfig())
    benchmark(lambda: infer_mbd(comparison, ASSISTS, ()))
