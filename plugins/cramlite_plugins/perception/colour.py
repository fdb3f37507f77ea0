"""Expert for colour classification: twelve basic colour words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.plugin import Expert, Inputs, Judged, Parameter, hookimpl

if TYPE_CHECKING:
    Words = np.ndarray[Any, np.dtype[np.int64]]

HUES = (("red", 12), ("orange", 38), ("yellow", 68), ("green", 165), ("cyan", 195), ("blue", 255), ("purple", 295),
        ("pink", 345), ("red", 360))  # fmt: skip
"""Upper end of each hue [deg]: the eleven basic colour terms of Berlin and Kay (1969) on the HSV circle, and cyan."""
GREYS = (("black", 0.20), ("grey", 0.80), ("white", 1.01))
WORDS = ("red", "orange", "yellow", "green", "cyan", "blue", "purple", "pink", "brown", "black", "grey", "white")


def colour(inputs: Inputs) -> Mapping[str, Any]:
    """Return the colour word of most pixels of an object; the other words with their shares."""
    pixels = inputs["view"].rgb[inputs["segment"].mask]
    pixels = pixels[:: max(1, len(pixels) // int(inputs.parameters["pixels"]))]
    shares = np.bincount(words(pixels), minlength=len(WORDS)) / len(pixels)
    order = np.argsort(-shares, kind="stable")
    said = [
        Judged(WORDS[k], float(shares[k]), f"{100 * shares[k]:.0f} % of its pixels have this colour") for k in order if shares[k] > 0
    ]
    best = said[0]
    return {"colour": Judged(best.value, best.confidence, best.reason, tuple(said[1:]))}


def words(pixels: np.ndarray[Any, np.dtype[np.uint8]]) -> Words:
    """Return the colour words of RGB pixels (N, 3) uint8, as indices (N,) into ``WORDS``."""
    rgb = pixels.astype(float) / 255
    value, low = rgb.max(axis=1), rgb.min(axis=1)
    spread = value - low
    hue = _hue(rgb, value, spread)
    names = np.array([WORDS.index(w) for w, _ in HUES])
    found = names[np.searchsorted([end for _, end in HUES], hue, side="right").clip(max=len(HUES) - 1)]
    warm = (hue >= 5) & (hue < 50)
    found[warm & (value < 0.68)] = WORDS.index("brown")  # a dark orange is what people call brown
    pale = spread < 0.15 * np.maximum(value, 0.25)
    greys = np.array([WORDS.index(w) for w, _ in GREYS])
    grey = greys[np.searchsorted([end for _, end in GREYS], value, side="right").clip(max=2)]
    dark = value < 0.12
    return np.asarray(np.where(pale | dark, grey, found))


def _hue(rgb: Any, value: Any, spread: Any) -> Any:
    """Hue of RGB colours [deg] (Smith, SIGGRAPH 1978)."""
    safe = np.where(spread > 0, spread, 1.0)
    r, g, b = rgb.T
    sector = np.where(value == r, ((g - b) / safe) % 6, np.where(value == g, (b - r) / safe + 2, (r - g) / safe + 4))
    return 60 * sector


@hookimpl
def experts() -> Iterable[Expert]:
    pixels = Parameter("pixels", 600, "at most that many are looked at: shares to 4 % at 95 %")
    return [
        Expert("hsv_colour", "the colour word of most pixels", ("view", "segment"), ("colour",), colour, "object",
               domains={"colour": WORDS}, cost_ms=0.4, parameters=(pixels,)),
    ]  # fmt: skip
