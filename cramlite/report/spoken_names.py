"""Names of a recording as people would say them: "big bowl" for ``SM_BigBowl``, "contents of the cup" for ``contents(cup)``."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping

from ..base.value import Value
from ..model.entity_name import EntityName

_LABELS = re.compile(r"^(SM|SK|SKM|BP|AD)_|_C(?=_\d+$)|_?Component$")
"""Parts that Unreal's editor adds to names."""
_DERIVED = re.compile(r"(contents|support)\((.*)\)(?:_(\d+))?")


class SpokenNames(Value):
    """Spoken names: a dictionary from the names of a recording; no two things get the same spoken name.

    Args:
        spoken: each name, and what is said.
    """

    spoken: Mapping[str, str]

    def __call__(self, name: str) -> str:
        """Return the spoken name of an entity; a name that is not in the recording is returned unchanged."""
        return self.spoken.get(name, name)

    def text(self, sentence: str, about: Iterable[str]) -> str:
        """Return a sentence in which some names of the recording are replaced by spoken names with an
        article."""
        names = sorted(about, key=len, reverse=True)
        if not names:
            return sentence
        found = "|".join(map(re.escape, names))
        return re.sub(rf"(\b(?:the|empty) )?(?<![\w/])({found})(?![\w/(])", lambda m: f"{m[1] or 'the '}{self(m[2])}", sentence)


def spoken_names(names: Iterable[str]) -> SpokenNames:
    """Return the names that texts for people use for some entities; where two would be equal, the original follows in brackets."""
    said = {name: _spoken(name) for name in dict.fromkeys(names)}
    often = Counter(said.values())
    return SpokenNames({n: s if often[s] == 1 else f"{s} ({n})" for n, s in said.items()})


def _spoken(name: str) -> str:
    derived = _DERIVED.fullmatch(name)
    if derived is not None:
        of, number = _spoken(derived[2]), derived[3]
        said = f"contents of the {of}" if derived[1] == "contents" else f"{'new ' if number else ''}place of the {of}"
        return f"{said} {number}" if number and number != "2" else said
    parsed = EntityName.parse(name)
    if parsed.part and "://" not in name:
        return f"{_words(parsed.part)} of the {_words(parsed.thing)}"
    return _words(name)


def _words(name: str) -> str:
    """Return a name as words in lower case: split at capitals and underscores, without prefixes that editors add.

    Abbreviations keep their capitals.
    """
    local = re.split(r"[#/:]", name.strip("<>"))[-1]
    words = re.findall(r"[A-Z]+(?![a-z])\d*|[A-Z]?[^\WA-Z_\d]+|\d+", _LABELS.sub("", local))
    said = " ".join(w if len(w) > 1 and w.isupper() else w.lower() for w in words)
    return said or name
