"""Errors with messages for the caller."""


class PerceptionError(Exception):
    """A failure. The program ends with code 1."""

    code = 1


class WrongUse(PerceptionError):
    """A flag or a file that the caller can correct. The program ends with code 2."""

    code = 2
