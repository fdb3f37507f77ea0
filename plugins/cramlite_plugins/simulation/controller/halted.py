"""End of a program by its own decision, whatever language it is in."""

from __future__ import annotations


class Halted(Exception):
    """Raised when the program gives up: URScript's ``halt``, or a failure that a typed program lets through."""
