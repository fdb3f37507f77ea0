"""Enumerations of words, each with a sentence that explains it."""

from __future__ import annotations

from enum import StrEnum


class Word(StrEnum):
    """Word of an enumeration: a string constant with an explanation of what it means.

    Args:
        says: what it means, a clause.
    """

    says: str

    def __new__(cls, text: str, says: str) -> Word:
        made = str.__new__(cls, text)
        made._value_, made.says = text, says
        return made
