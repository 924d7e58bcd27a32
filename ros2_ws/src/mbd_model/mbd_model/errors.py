"""The one base class of every error this suite raises about its input."""


class MbdError(ValueError):
    """Input that cannot be used. The text states what was wrong, what was expected and what to do."""
