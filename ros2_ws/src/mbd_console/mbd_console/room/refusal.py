"""Why the room is not recorded, in the words of the table of texts."""

from __future__ import annotations

from mbd_model.errors import MbdError

from mbd_console.words.texts import ENGLISH


class RoomRefusedError(MbdError):
    """Something of a film of the room that is not taken.

    Args:
        text: name of the sentence in the table of texts.
        status: of HTTP.
        values: that are filled into the sentence.
    """

    def __init__(self, text: str, status: int, **values: object) -> None:
        super().__init__(ENGLISH(text, **values))
        self.text, self.status, self.values = text, status, values
