"""What can be wrong with a bag."""

from __future__ import annotations

from mbd_model.errors import MbdError


class BagError(MbdError):
    """A bag that cannot be written or read. The text states what was wrong, what was expected and what to do."""
