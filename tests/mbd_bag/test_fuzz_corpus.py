"""The corpus of `tools/fuzz`, as it lies and changed by a seed, is answered with messages or one sentence."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from mbd_bag.repairing.fuzzing import TARGETS, corpus, give, mutated

SEEDS = corpus(Path(__file__).with_name("fuzz_corpus"))


@pytest.mark.parametrize("target", TARGETS)
def test_no_seed_and_none_changed_is_answered_badly(target: str):
    for _, data in SEEDS[target]:
        give(target, data)
    for data in islice(mutated(SEEDS[target], np.random.default_rng(5)), 150):
        give(target, data)


def test_what_raises_anything_else_is_noticed(monkeypatch: pytest.MonkeyPatch):
    def broken(data: bytes) -> None:
        raise KeyError(data)

    monkeypatch.setitem(TARGETS, "yaml", broken)
    with pytest.raises(KeyError):
        give("yaml", b"")
