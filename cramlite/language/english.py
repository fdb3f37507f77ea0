"""English for the grammar: small words by their function, forms of verbs and nouns, and the splitting of a text into words."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from ..model.world.colour_words import COLOURS
from .phrases import Phrases

Words = tuple[str, ...]
_TABLES: Mapping[str, Any] = yaml.safe_load((Path(__file__).parent / "english.yaml").read_text(encoding="utf-8"))


def _phrases(text: str) -> tuple[Words, ...]:
    """Split a text at "|" into phrases, and return them, the longest first."""
    found = {tuple(p.split()) for p in text.split("|")}
    return tuple(sorted(found, key=lambda p: (-len(p), p)))


def _table(name: str) -> tuple[Words, ...]:
    return _phrases(_TABLES[name])


def _patterns(name: str) -> Phrases:
    return Phrases(_TABLES[name], {**_TABLES["classes"], "next": _TABLES["next"]})


def _set(name: str) -> frozenset[str]:
    return frozenset(_TABLES[name].split())


def _by_word(name: str) -> dict[str, Any]:
    """Return the meaning of each word, from a table that lists the words of each meaning."""
    return {word: meaning for meaning, words in _TABLES[name].items() for word in words.split()}


STOPS = frozenset(",.;!?:")
THE, ONE, EVERY = _set("the"), _set("one"), _set("every")
NUMBERS: Mapping[str, int] = _by_word("numbers")
ORDINALS: Mapping[str, int] = _by_word("ordinals")
"""Ordinals; -1 is the last."""
PRONOUNS: Mapping[str, bool] = {"it": False, "them": True, "they": True, "those": True, "these": True, "this": False, "that": False}
"""Words that stand for what was named before -> whether for several."""
STANDING = frozenset({"it", "them", "they", "its", "their"})
"""Words that stand for things in a clause that only tells."""
SIDES: Mapping[str, str] = _by_word("sides")
"""Words for a position among others -> the position."""
SIZES: Mapping[str, int] = _by_word("sizes")
"""Words for a size among others -> 1 the largest, -1 the smallest, 2 the tallest, -2 the lowest."""
EXTRA = _set("extra")
"""Words within a description that say nothing by themselves here."""
BESIDE: Mapping[Words, str] = {p: side for side, text in _TABLES["beside"].items() for p in _phrases(text)}
"""Prepositions of relations that are judged by positions -> the relation."""
AMONG = _table("among")
"""Words before a position among others: "the bowl on the left", "at the back"."""
UNDER, TOP = _table("under"), _table("top")
TO = _table("to")
"""Prepositions of a destination that leave open how it is there."""
OF = _table("of")
"""Prepositions of a part and its whole: "the top drawer of the cabinet"."""
WITH = _table("with")
"""Words before what is on or in the described thing."""
THAT = _patterns("that")
"""Words before a relation of a description that say nothing more."""
POLITE, CLOSING = _patterns("polite"), _patterns("closing")
"""Words before and behind what is asked for that change nothing."""
PREPARE = _table("prepare")
"""Verbs of what only leads to something: "find the cup and ..."."""
LATER = _set("later")
"""Words by which what follows is done after what came before."""
WISH, UNWISH = _patterns("wish"), _patterns("unwish")
"""Words before what should, or should not, hold in the end."""
BE, NOT_BE = _patterns("be"), _patterns("not be")
"""Words between what is meant and what should, or should not, hold of it in the end."""
FINITE = Phrases("$finite | $modal", _TABLES["classes"])
"""Verbs that end a description, and words before them."""
DISMISSED = _patterns("dismissed")
"""Words before the dismissed thing of a self-correction."""
FILLERS, REPAIRS, EMPHASIS = _patterns("fillers"), _patterns("repairs"), _set("emphasis")
"""Words that say nothing anywhere, that take back what was said before them, and that say nothing before a preposition."""
NONE, EXCEPT, CONTRAST = _patterns("none"), _patterns("except"), _patterns("contrast")
"""Words before things of which something shall not be so, that are left out, or that are not meant."""
TOLD = frozenset({"is", "are", "'s", "was", "were", "lies", "stands", "sits", "hangs", "rests"})
"""Verbs that may also say how things are."""
TOO, WILL_DO, NEEDS = _patterns("too"), _patterns("will do"), _patterns("needs")
"""Words behind what is meant as well, behind what suits, and before a verb in its "-ing" form that tells what is to be done."""
ASIDE = _set("aside")
"""Adverbs of places, which are names where a thing is called so."""
IS_NOT = _patterns("is not")
"""Words between what is meant and what should not hold of it, behind a wish."""
SWAPPED, EXISTS = _patterns("swapped"), _patterns("exists")
"""Words behind things that change places, and before what there shall be."""
HOLDS, REASONS = _patterns("holds"), _patterns("reasons")
"""Verbs between a place and what shall be there, and words before a reason."""
CONDITIONS, PROVISOS = _patterns("conditions"), _patterns("provisos")
"""Words before what must be so, and before what must not be so, that a request holds."""
LASTING = _set("lasting")
"""Verbs by which a condition asks for what it says: "provided that it stays upright"."""
TENS: Mapping[str, int] = _TABLES["tens"]
"""Numbers of amounts."""
NUMBER = _patterns("number")
"""Words before the number of a thing."""
PRELUDE = _set("prelude")
"""Words of announcements: "here is what I want: ..."."""
ORIGIN, SWAP = _patterns("origin"), _patterns("swap")
"""Words for where a thing was, and verbs by which two things change places."""
TOWARD = _table("toward")
"""Prepositions of a destination, which describe nothing that is there."""
CALLED = _set("called")
"""Words before a thing's own name."""
PLACED = _set("placed")
"""Forms of verbs that may stand before a place and change nothing."""
NEGATIVE, CONDITIONAL = _set("negative"), _set("conditional")
PACKAGES = _set("packages")
"""Words for packages of products, which need not be part of their names: "the ketchup bottle", "a can of soup"."""
TECHNICAL = _set("technical")
"""Words of names that programs give, which nobody says."""
FURNITURE = _set("furniture")
"""Nouns for what things stand on, one of which may be called by another."""
GENERAL = _set("general")
"""Nouns for anything that can be moved."""
ANYTHING: Words = (_TABLES["anything"],)
ENDS = _set("ends")
"""Words behind a side that say nothing more: "the left end"."""
REGIONS = _set("regions")
"""Nouns for a region of a thing."""
PLAIN, LOW = _set("plain"), _set("low")
"""Words of regions that name no place of their own; of what is under something."""
INWARD = _set("inward")
"""Words of prepositions of what is enclosed."""
ROBOT, VIEWER = _set("robot"), _set("viewer")
"""Who acts and who looks, and is no thing of the scene."""
SHADES: Mapping[str, str] = _by_word("shades")
"""Other words for colours -> the colour."""
MATERIALS: Mapping[str, str] = _TABLES["materials"]
"""Adjectives of materials -> the noun."""
UNCOLOURED = _set("uncoloured")
"""Words between colours."""
AUXILIARY, STATIVE, LIGHT = _set("auxiliary"), _set("stative"), _set("light")
"""Verbs that say nothing by themselves, that tell how things are, and small words that a request may have anywhere."""
WISHED, OBLIGING, PAST = _set("wished"), _set("obliging"), _set("past")
"""Words of wishes and of duties, and verbs that tell of the past."""
PERSONS, POSSESSIVE = _set("persons"), _set("possessive")
"""Subjects of comments, and owners."""
REASON, SUITS, INDIFFERENT = _patterns("reason"), _patterns("suits"), _patterns("indifferent")
"""Words before reasons and purposes, what says that it suits, and words before what does not matter."""
WHILE = _set("while")
"""Words before a clause of time or a condition, with its subject."""
JOINTS, OPENS, MATRIX = _set("joints"), _set("opens"), _set("matrix")
"""Words that join clauses, that end what introduces a request, and that begin it."""
PERFECT = _set("perfect")
"""Auxiliary verbs of the perfect."""
FORGETTING, ADVERSE = _set("forgetting"), _set("adverse")
"""Words that a denial turns into a request, and words that turn one into its contrary."""
LIMITING, ADVERBS, ABSTRACT, TIMED = _set("limiting"), _set("adverbs"), _set("abstract"), _set("timed")
"""Words in "-ly" that say how far, further adverbs, nouns of time and manner, and prepositions before these."""
NARRATED, NARRATING, CLAUSAL, DEPENDENT = _set("narrated"), _set("narrating"), _set("clausal"), _set("dependent")
"""Verbs of stories in the past and in the present, words that join clauses, and those before a clause that depends on another one."""
ENDED, PREPOSED, DATED = _set("ended"), _set("preposed"), _set("dated")
"""Words with which no clause ends, prepositions before the subject of a clause, and times before it."""
PLEASED, EXCLAIMED = _set("pleased"), _patterns("exclaimed")
"""Adjectives before what is wished, and exclamations and comments between commas."""
PROVIDING, TITLES, INTENDED = _set("providing"), _set("titles"), _set("intended")
"""Words of conditions, at the beginning of a clause, nouns before the numbers of a list, and verbs in the past that still ask."""
MODAL, RELATIVE = _set("modal verbs"), _set("relative pronouns")
"""Verbs that oblige or permit, and pronouns that begin a clause about what was just named."""
SPEAKING, OBLIGATION = _set("speaking"), _set("obligation")
"""Verbs by which somebody may report a request, and words of duties and of the future."""
ORIENTED = _set("oriented")
"""Words by which a purpose says how something shall stand."""
TOGETHER, ADDRESS = _patterns("together"), _set("address")
"""Words behind things that shall stand beside one another, and nouns by which somebody is spoken to."""
QUESTIONS, WITHIN, CENTRAL = _patterns("questions"), _patterns("within"), _patterns("central")
"""Words before what is only pointed at, before the distance from a middle, and behind it."""
DEICTIC, COPULAR, ASKING = _set("deictic"), _set("copular"), _set("asking")
"""Words before the subject of a comment, verbs that only tell how something is, and verbs that begin a question."""
GOING = _patterns("going")
"""Words before where the robot shall go."""
DEGREE, POINTED = _patterns("degree"), _patterns("pointed")
"""Words before a state that is only told, and words by which a thing is pointed at."""
SO_DOES = _patterns("so does")
"""Words before a thing of which the same is asked."""
UP_TO = _set("up to")
"""Words between the ends of a range of numbers."""
GROUPS = _set("groups")
"""Nouns for several things together."""
ERECT = _set("erect")
"""Verbs whose "up" says how a thing shall stand."""
APPOSED, IDENTIFIED, BASED = _patterns("apposed"), _patterns("identified"), _patterns("based")
"""Words before a further description of what was just named, before another name of it, and behind the lowest thing of a stack."""
AMOUNTING = _set("amounting")
"""Words before an amount."""
NOT_YET = Phrases("not | no longer | never | anywhere (but|except|other than)")
"""Denials within a request in free order."""
SOURCES = (("off",), ("out",), ("from",))
"""First words of prepositions of where something is taken from."""
DIRECTED = frozenset({"into", "onto", "off", "out", "from", "on_top_of"})
"""Prepositions that tell where a motion ends, whatever its verb."""
TELLING = frozenset({*SIDES, *ORDINALS, *SIZES}) | frozenset(COLOURS)
"""Words that tell one of several things apart."""
UNITS: Mapping[str, str] = _TABLES["units"]
VIEWS: Mapping[str, tuple[Words, ...]] = {name: _phrases(text) for name, text in _TABLES["views"].items()}
"""View -> the words that name it."""
FUNCTION = frozenset({*SIDES, *ORDINALS, *SIZES} | {p[0] for p in (*BESIDE, *UNDER) if len(p) == 1})
"""Words that stand for a place or an order, where they are no name."""
SMALL = STOPS | AUXILIARY | LIGHT | THE | ONE | EVERY | NEGATIVE | PERSONS | JOINTS | EXTRA | {*PRONOUNS, *NUMBERS, *SIDES}
"""Words that are no verb."""
HUES = frozenset(COLOURS) | frozenset(SHADES)
"""Words for colours."""
BINDING, ALONE = (tuple(map(frozenset, _table(name))) for name in ("binding", "alone"))
"""Signs that together may change a goal, in any clause and in one that stands alone."""
_FORMS: Mapping[str, str] = _TABLES["irregular"]
_PLURALS: Mapping[str, str] = _TABLES["plurals"]
TOP_WORD: Words = ("on_top_of",)
AXIS = {"+": "plus", "plus": "plus", "-": "minus", "minus": "minus"}
"""Sign of a direction along an axis of the world -> its name in words such as "minus_x"."""


def tokens(text: str) -> Words:
    """Split a sentence into words in lower case; commas, ends of sentences and a possessive "'s" are words of
    their own.

    Phrases for "on top of" become one word.
    """
    text = re.sub(r"\bSTOP\b", ".", text) if text.isupper() else text
    said = re.sub(r"(?<=[\w\s])[&+](?=[\w\s])", " and ", re.sub(r"\bi\.e\.", "that is", text.lower()))
    said = re.sub(r"-+>|=+>|\u2192", " to ", said.replace("\u2019", "'"))
    said = re.sub(r"(?<![\w-])(?:([+-])|(plus|minus) )([xy])(?= |-)", lambda found: f"{AXIS[found[1] or found[2]]}_{found[3]}", said)
    said = re.sub(r"[()\u2013\u2014]|\s-\s|\.\.+|\u2026", " , ", said).replace("-", " ").replace("#", " number ")
    for short, whole in _TABLES["contracted"].items():
        said = re.sub(rf"\b{short}(?!')\b", whole, said)
    for ending, whole in _TABLES["endings"].items():
        said = re.sub(rf"(?<=\w){ending}\b", f" {whole}", said)
    said = re.sub(r"\b(some(?:body|one)|every(?:body|one)|who|s?he)'s (?=been|left|gone|put|taken|made|lost|\w+ed\b)", r"\1 has ", said)
    said = re.sub(rf"\b({'|'.join(_TABLES['copula'].split())})'s\b", r"\1 is", said)
    said = re.sub(r"(\w)'s\b", r"\1 's", said)
    said = re.sub(r"(\w)s'(?=\s)", r"\1s", said)
    return _joined(tuple(re.findall(r"'s|[\w/]*\w(?:\.\d+)?|[,.;!?:]", said.replace('"', " "))))


def _joined(words: Words) -> Words:
    found: list[str] = []
    k = 0
    while k < len(words):
        ends = starts(words, k, TOP)
        found.append(TOP_WORD[0] if ends else words[k])
        k = ends[0] if ends else k + 1
    return tuple(found)


def forms(verb: str) -> tuple[str, str]:
    """Return the past participle and the "-ing" form of a verb."""
    if verb in _FORMS:
        participle, gerund = _FORMS[verb].split()
        return participle, gerund
    stem = verb.removesuffix("e")
    if re.fullmatch(r"(?:[^aeiou]|qu)*[aeiou][^aeiouwxy]", verb):
        stem += verb[-1]
    return stem + "ed", stem + "ing"


def singular(word: str) -> str:
    """Return the singular of a noun; other words are returned unchanged."""
    if word in _PLURALS:
        return _PLURALS[word]
    if len(word) > 3 and word.endswith("ies"):
        return word[:-3] + "y"
    if word.endswith(("ches", "shes", "xes", "sses", "zes")):
        return word[:-2]
    return word[:-1] if len(word) > 3 and word.endswith("s") and not word.endswith(("ss", "us", "is")) else word


def plural(word: str) -> bool:
    """Check whether a noun is in the plural."""
    return singular(word) != word


def starts(words: Words, at: int, phrases: Phrases | tuple[Words, ...]) -> tuple[int, ...]:
    """Return the end positions of the phrases that begin at a position of a sentence, longest first."""
    if isinstance(phrases, Phrases):
        return phrases.ends(words, at)
    return tuple(at + len(p) for p in phrases if words[at : at + len(p)] == p)


def vocabulary() -> frozenset[str]:
    """Return every word of the grammar's tables of English words."""
    tables = (BESIDE, AMONG, UNDER, TOP, OF, WITH, PREPARE)
    patterns = (THAT, POLITE, CLOSING, WISH, UNWISH, BE, NOT_BE, FILLERS, REPAIRS, NONE, EXCEPT, CONTRAST, ORIGIN, SWAP)
    single = (THE, ONE, EVERY, NUMBERS, ORDINALS, PRONOUNS, SIDES, SIZES, EXTRA, PLACED, STOPS, {"and", "or", "then", "by", "other"})
    words = {w for table in tables for phrase in table for w in phrase} | {w for group in single for w in group}
    return frozenset(words | {w for patterns_ in patterns for w in patterns_.vocabulary})
