"""Ranges of the seeds of drawn problems, by what they are for: development or measurement. Nothing of
cramlite or LIBERO is imported."""

from __future__ import annotations

DEVELOPMENT = range(0, 400)
"""Seeds that may be drawn, looked at and developed on."""
MEASURED = (range(1000, 1100), range(1100, 1160), range(1160, 1460))
"""Seeds for measurements: each range may be used once, for one measurement."""


def seeds_of(text: str, *, measure: bool = False) -> range:
    """Parse a text of seeds as a range: "0:10" means 0 to 9, and "7" means 7 alone.

    Args:
        measure: those of a measurement are meant.

    Raises:
        ValueError: it is no such text, or the seeds are not for this.
    """
    first, colon, end = text.partition(":")
    try:
        found = range(int(first), int(end) if colon else int(first) + 1)
    except ValueError:
        raise ValueError(f"The seeds are '{text}'; write 0:10, which ends with 9, or one number.") from None
    wanted = MEASURED if measure else (DEVELOPMENT,)
    if not found or not any(found[0] in part and found[-1] in part for part in wanted):
        said = " or ".join(f"{part.start} to {part.stop - 1}" for part in wanted)
        more = "" if measure else "; those of a measurement are opened with --measure, once"
        raise ValueError(f"The seeds '{text}' are not within {said}{more}.")
    return found
