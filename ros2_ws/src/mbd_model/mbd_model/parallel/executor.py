"""What every executor of many items promises: results in item order, bounded memory, errors that name the item."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import NoReturn, Protocol, TypeVar

from mbd_model.errors import MbdError

Item = TypeVar("Item")
Result = TypeVar("Result")

# Items at work, waiting or done before their turn, per worker: enough to keep all busy beside one that takes longer.
AHEAD = 3


class ItemError(MbdError):
    """An item that could not be computed. The text names it and states why."""


class Executor(Protocol):
    """Computes one function of many items."""

    def run_all(
        self, function: Callable[[Item], Result], items: Iterable[Item], name: Callable[[Item], str] = str
    ) -> Iterator[Result]:
        """The function's result for each item, in the order of the items, whoever computed it and when.

        Items are taken as they are needed: at most AHEAD of them per worker are between being taken and their result
        being yielded, so that memory does not grow with their number. Closing the iterator ends what is at work.

        Args:
            function: of a module that the workers can import; what it returns must be picklable. An item may be
                computed twice when its worker is killed, so it must not mind what its first try left.
            items: any number, picklable.
            name: what an error calls an item.

        Raises:
            ItemError: the function raised an MbdError, or the item's worker was killed and its second one too.
            Exception: what else the function raised, with a note that names the item, at the item's turn.
        """
        ...


def raise_named(error: Exception, name: str, trace: str = "") -> NoReturn:
    """Raise what computing an item raised, so that it names the item.

    Args:
        error: as the function raised it.
        name: of the item.
        trace: of the worker, for an error nobody expected.

    Raises:
        ItemError: in place of an MbdError that does not name the item.
        Exception: the error itself otherwise.
    """
    if isinstance(error, MbdError):
        if name in str(error):
            raise error
        raise ItemError(f"{name}: {error}") from error
    error.add_note(f"while computing {name}" + (f"; in its worker:\n{trace}" if trace else ""))
    raise error
