"""Words for colours: the eleven basic colour terms of Berlin and Kay (1969), and cyan."""

from __future__ import annotations

import colorsys
from collections import Counter

from .thing import Thing

HUES = (("red", 12), ("orange", 38), ("yellow", 68), ("green", 165), ("cyan", 195), ("blue", 255), ("purple", 295),
        ("pink", 345), ("red", 360))  # fmt: skip
"""Colour words, each with the upper end of its range of hues on the HSV circle [deg]."""
COLOURS = ("red", "orange", "yellow", "green", "cyan", "blue", "purple", "pink", "brown", "black", "grey", "white")
PALE, DARK, LIGHT = 0.15, 0.2, 0.9
"""Limits of grey colours: the spread of the RGB channels relative to the largest one below which a colour is grey, the value below which
it is black, and the value from which it is white."""
BROWN = 0.68
"""HSV value below which a dark orange is called brown."""


SEEN_WHITE, SEEN_BLACK, DULL = 0.65, 0.3, 0.75
"""Limits of the colours of textures, which print and light make duller than colours that somebody states: value from which a grey one may
be called white, value below which it may be called black, and value below which a red or an orange may be called brown."""
REDDISH = 25
"""Hue up to which a dull colour may still be called red [deg]."""


def colour_of(thing: Thing) -> str:
    """Return the colour word of most geoms of a thing; "" if they are grey, which is also the colour of geoms
    that state none."""
    found = Counter(word for g in thing.geoms if not g.part and (word := colour_word(g.rgba[:3])))
    return found.most_common(1)[0][0] if found else ""


def colour_word(rgb: tuple[float, ...]) -> str:
    """Return the word for a colour, channels from 0 to 1; "" for a grey."""
    spread, value = max(rgb) - min(rgb), max(rgb)
    if spread < PALE * max(value, 0.25) or value < 0.12:
        return "black" if value < DARK else "white" if value >= LIGHT else ""
    degrees = 360 * colorsys.rgb_to_hsv(rgb[0], rgb[1], rgb[2])[0]
    if 5 <= degrees < 50 and value < BROWN:
        return "brown"
    return next(word for word, end in HUES if degrees < end or end == 360)


def colour_words(rgb: tuple[float, ...]) -> tuple[str, ...]:
    """Return all words by which people may call a colour of a texture, channels from 0 to 1."""
    spread, value = max(rgb) - min(rgb), max(rgb)
    if spread < PALE * max(value, 0.25) or value < 0.12:
        named = (("black", value < SEEN_BLACK), ("grey", DARK / 2 < value < LIGHT), ("white", value >= SEEN_WHITE))
        return tuple(word for word, so in named if so)
    degrees = 360 * colorsys.rgb_to_hsv(rgb[0], rgb[1], rgb[2])[0]
    hue = next(word for word, end in HUES if degrees < end or end == 360)
    named = ((hue, True), ("red", degrees < REDDISH), ("brown", 5 <= degrees < 50 and value < DULL))
    return tuple(dict.fromkeys(word for word, so in named if so))
