"""Counterbalanced orders: Williams squares, permuted blocks, shuffled and fixed ones."""

from __future__ import annotations

from enum import StrEnum

import numpy as np


class Order(StrEnum):
    """How the order of one participant comes about."""

    WILLIAMS = "williams"
    RANDOM = "random"
    FIXED = "fixed"
    BLOCKS = "blocks"


def williams_rows(count: int) -> tuple[tuple[int, ...], ...]:
    """The rows of a Williams design: each item is in each position equally often, and follows each other equally often.

    ``count`` rows for an even number; for an odd one twice as many (the square and its mirror image), since no single
    square of odd size balances what follows what.

    Args:
        count: of items, at least 1.

    References:
        Williams, E. J. (1949): Experimental designs balanced for the estimation of residual effects of treatments.
        Australian Journal of Scientific Research A 2, 149-168.
    """
    # 0, n-1, 1, n-2, ...: the differences of neighbours are all different, so that each pair follows once.
    first = [k // 2 if k % 2 == 0 else count - 1 - k // 2 for k in range(count)]
    rows = [tuple((item + shift) % count for item in first) for shift in range(count)]
    if count % 2 and count > 1:
        rows += [tuple(reversed(row)) for row in rows]
    return tuple(rows)


def orders(kind: Order, items: int, participants: int, rng: np.random.Generator) -> tuple[tuple[int, ...], ...]:
    """For each participant the items in order, as numbers from 0.

    WILLIAMS: the rows of the design, each once, shuffled, before any comes again; balanced when the number of
    participants is a multiple of the number of rows. RANDOM: a shuffled order each. FIXED: as listed. BLOCKS: one item
    each; in every block of as many participants as there are items each item comes once.

    Args:
        kind: of the orders.
        items: how many there are, at least 1.
        participants: how many there are.
        rng: of what is shuffled.
    """
    if kind is Order.FIXED:
        return (tuple(range(items)),) * participants
    if kind is Order.RANDOM:
        return tuple(tuple(int(k) for k in rng.permutation(items)) for _ in range(participants))
    rows = williams_rows(items) if kind is Order.WILLIAMS else tuple((k,) for k in range(items))
    found: list[tuple[int, ...]] = []
    while len(found) < participants:
        found += [rows[k] for k in rng.permutation(len(rows))]
    return tuple(found[:participants])


def balanced_at(kind: Order, items: int) -> int:
    """Of how many participants the number must be a multiple for the orders to be balanced; 1: of any."""
    if kind is Order.WILLIAMS:
        return len(williams_rows(items))
    return items if kind is Order.BLOCKS else 1
