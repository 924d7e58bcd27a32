"""A person's own file of ROS parameters, looked through before any node is started with it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mbd_model.errors import MbdError
from mbd_model.parameters import ParameterTable


def own_file(argument: str, word: str, tables: Sequence[ParameterTable]) -> tuple[tuple[str, str], ...]:
    """The file as a NodeSpec's ``config`` has it; () where none is given.

    Args:
        argument: that gives it, for the text of an error.
        word: path of the file; "" for none.
        tables: of the nodes that it is given to.

    Raises:
        MbdError: no such file, no ROS parameters, none for these nodes, or one that they would refuse.
    """
    if not word:
        return ()
    file = Path(word).expanduser().resolve()
    if not file.is_file():
        raise MbdError(f"{argument}:={word} is no file; give an existing file of ROS parameters")
    try:
        given = [table.in_file(file) for table in tables]
    except MbdError as error:
        raise MbdError(f"{argument}:={word}: {error}") from error
    if not any(given):
        names = " or ".join(table.node for table in tables)
        raise MbdError(f"{argument}:={word} has no parameter for {names}; expected a section '/**' or of that name")
    return (("", str(file)),)
