"""Refusals of places that have too little room for what is put there, with remedies."""

from __future__ import annotations

from cramlite.model import Remedy
from cramlite.plugin import Refused

from ..motion_planning.space import refusal


def taken_by(said: str, thing: str, place: str, other: str, overlap: float, there: tuple[str, ...]) -> Refused:
    """Return the refusal of a place that another thing takes.

    Args:
        overlap: of the outlines [m2].
        there: names of what stands there.
    """
    more = f"there is no room for '{thing}' beside '{other}' on or in '{place}', {1e4 * overlap:.1f} cm2 are lacking"
    return _refusal(said, Remedy(f"room {place}", f"{more}: have '{other}' put elsewhere, or name another place", overlap), there)


def too_narrow(said: str, thing: str, place: str, out: float, there: tuple[str, ...]) -> Refused:
    """Return the refusal of an opening that is too narrow by a length [m]."""
    more = f"the opening of '{place}' lacks {1000 * out:.0f} mm for '{thing}'"
    says = f"{more}: take a smaller thing, have it put down otherwise, or name another container"
    return _refusal(said, Remedy(f"opening {place}", says, out), there)


def too_high(thing: str, region: str, reaches: float, over: float) -> Refused:
    """Return the refusal of a place in a region that ends lower, by a length [m], than where the origin of what stands there is."""
    said = f"its origin would be {1000 * over:.0f} mm too high for '{region}', which reaches {1000 * reaches:.0f} mm above the face in it"
    more = f"'{region}' reaches {1000 * reaches:.0f} mm above the face in it, {1000 * over:.0f} mm too little for the origin of '{thing}'"
    says = f"{more}: name the thing itself or a higher region, or make the site of this one higher"
    return _refusal(said, Remedy(f"region {region}", says, over), ())


def _refusal(said: str, remedy: Remedy, there: tuple[str, ...]) -> Refused:
    return refusal(said, blocking=there, remedy=remedy)
