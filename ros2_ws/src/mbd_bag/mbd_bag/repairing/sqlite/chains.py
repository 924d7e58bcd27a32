"""Which rows own the further pages of their messages: where two claim one, or one has lost its way, one is damaged.

sqlite adds pages at the end of a file, and rosbag2 only adds rows: the further pages of a message follow each other,
and those of messages lie in the order of their ids. That is asked for only where something speaks against a row, as a
file may have been written otherwise.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections.abc import Collection, Sequence
from itertools import pairwise

from mbd_bag.repairing.sqlite.pages import Pages
from mbd_bag.repairing.sqlite.records import TREE_KINDS
from mbd_bag.repairing.sqlite.rows import MessageRow, follow

_CLAIMS = 10  # of a page, on average


def rows_with_their_pages(
    pages: Pages, rows: Sequence[MessageRow], others: Collection[int]
) -> tuple[list[MessageRow], int]:
    """The rows whose further pages are all there and are no other's, and how many are not.

    Args:
        pages: of the file.
        rows: of messages, by ascending id.
        others: numbers of the pages that rows of other tables go on in.
    """
    chains: dict[int, array[int]] = {}
    lost: set[int] = set()
    owners: dict[int, list[int]] = {}
    # An intact file takes one for each page; one made to take long, one for each page of each row.
    steps = _CLAIMS * pages.count
    for k, row in enumerate(rows):
        if not row.cell.onward:
            continue
        chain = _chain(pages, row) if steps >= 0 else None
        if chain is None:
            lost.add(k)
            continue
        steps -= len(chain)
        chains[k] = chain
        for number in chain:
            owners.setdefault(number, []).append(k)
    disputed = {k for claims in owners.values() if len(claims) > 1 for k in claims}
    elsewhere = {*others, *pages.free(), *pages.maps()}
    unclaimed = [
        n for n in range(2, pages.count + 1) if n not in owners and n not in elsewhere and _is_further(pages, n)
    ]
    agreed = sorted(k for k in chains if k not in disputed)
    doubts = {k: _doubts(k, chains, agreed, unclaimed) for k in chains if k in disputed or unclaimed}
    for claims in (c for c in owners.values() if len(c) > 1):
        least = min(doubts[k] for k in claims)
        fitting = [k for k in claims if doubts[k] == least]
        if len(fitting) == 2:
            fitting = _by_the_gap(fitting, chains, agreed, unclaimed)
        lost |= {k for k in claims if k not in fitting or len(fitting) > 1}
    lost |= {k for k in agreed if doubts.get(k, 0) and unclaimed}
    return [row for k, row in enumerate(rows) if k not in lost], len(lost)


def _chain(pages: Pages, row: MessageRow) -> array[int] | None:
    """The numbers of a row's further pages; None when they do not make it up."""
    chain = array("Q")
    kinds: set[int] = set()

    def add(number: int, page: memoryview) -> None:
        chain.append(number)
        kinds.add(page[0])

    # The first byte of a further page is that of the next one's number: below any tree's in a file of up to 134 GB.
    intact = follow(pages, row.cell, add) and not kinds & TREE_KINDS and len(set(chain)) == len(chain)
    return chain if intact else None


def _is_further(pages: Pages, number: int) -> bool:
    page = pages.page(number)
    return page is not None and page[0] not in TREE_KINDS


def _doubts(k: int, chains: dict[int, array[int]], agreed: list[int], unclaimed: list[int]) -> int:
    """How many steps of a row's chain pass over pages that nobody else claims, or go against the order of ids."""
    chain = chains[k]
    place = bisect_left(agreed, k)
    before = [c for c in agreed[max(0, place - 2) : place] if c != k]
    after = [c for c in agreed[place : place + 3] if c != k][:2]
    doubts = sum(1 for a, b in pairwise(chain) if _passes_over(a, b, unclaimed))
    # By two of each side: one of them may be the damaged one.
    ends, begins = [chains[c][-1] for c in before], [chains[c][0] for c in after]
    too_early = bool(ends) and min(ends) > chain[0]
    too_late = bool(begins) and max(begins) < chain[-1]
    return doubts + too_early + too_late


def _by_the_gap(claims: list[int], chains: dict[int, array[int]], agreed: list[int], unclaimed: list[int]) -> list[int]:
    """Which of two rows the pages are that both go on in: the other one's own lie unclaimed on its side of them."""
    place = bisect_left(agreed, claims[0])
    after = bisect_left(agreed, claims[1])
    first, last = chains[claims[1]][0], chains[claims[1]][-1]
    begin = chains[agreed[place - 1]][-1] if place else 1
    end = chains[agreed[after]][0] if after < len(agreed) else (unclaimed[-1] + 1 if unclaimed else last)
    before_it = _passes_over(begin, first, unclaimed)
    behind_it = _passes_over(last, end, unclaimed)
    if before_it == behind_it:
        return claims
    return [max(claims)] if before_it else [min(claims)]


def _passes_over(page: int, onward: int, unclaimed: list[int]) -> bool:
    """Whether going from a page to another one goes back, or passes over pages that nobody claims."""
    if onward <= page:
        return True
    k = bisect_left(unclaimed, page + 1)
    return k < len(unclaimed) and unclaimed[k] < onward
