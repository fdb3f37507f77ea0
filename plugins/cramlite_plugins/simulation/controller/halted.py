"""End of a program by its own decision, whatever language it is in."""

from __future__ import annotations


class Halted(Exception):
    """Raised when a program ends itself: by URScript's ``halt``, or when a step fails that a typed program
    does not retry."""
