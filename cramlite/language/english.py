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
"""Ordinal number word -> its number, where "last" is -1."""
PRONOUNS: Mapping[str, bool] = {"it": False, "them": True, "they": True, "those": True, "these": True, "this": False, "that": False}
"""Pronoun for things named before -> whether it stands for several things."""
STANDING = frozenset({"it", "them", "they", "its", "their"})
"""Pronouns that stand for things in a clause that states something and asks for nothing."""
SIDES: Mapping[str, str] = _by_word("sides")
"""Word for the position of a thing among others -> the position."""
SIZES: Mapping[str, int] = _by_word("sizes")
"""Word for the size of a thing among others -> 1 for the largest, -1 the smallest, 2 the tallest, -2 the lowest."""
EXTRA = _set("extra")
"""Words in a description that do not help to tell which thing it describes, such as "lovely"."""
BESIDE: Mapping[Words, str] = {p: side for side, text in _TABLES["beside"].items() for p in _phrases(text)}
"""Preposition that relates the positions of things -> the spatial relation, such as "next to"."""
AMONG = _table("among")
"""Words that introduce a position among other things: "on" of "the bowl on the left", "at" of "at the back"."""
UNDER, TOP = _table("under"), _table("top")
TO = _table("to")
"""Prepositions that name a destination, but not whether the thing goes on it or into it, such as "to"."""
OF = _table("of")
"""Prepositions between a part and its whole: "of" of "the top drawer of the cabinet"."""
WITH = _table("with")
"""Words that introduce the content or the load of a described thing, such as "containing"."""
THAT = _patterns("that")
"""Words that introduce a relation in a description and have no meaning of their own, such as "that is"."""
HALT, CALLED_OFF = _set("halt"), _set("called off")
"""Verbs that ask the robot to do nothing more, and participles that say so of its task, such as "cancelled"."""
POLITE, CLOSING = _patterns("polite"), _patterns("closing")
"""Polite phrases before a request, and closing phrases after it, which do not change its meaning."""
PREPARE = _table("prepare")
"""Verbs of an action that only prepares the requested one: "find the cup and ..."."""
LATER = _set("later")
"""Words that mark an action as later than the one before, such as "then"."""
WISH, UNWISH = _patterns("wish"), _patterns("unwish")
"""Words that introduce a wished state of the scene, and an unwished one, such as "I want" and "I do not want"."""
BE, NOT_BE = _patterns("be"), _patterns("not be")
"""Words between a thing and the state that it should have, and those between a thing and the state that it should not have."""
FINITE = Phrases("$finite | $modal", _TABLES["classes"])
"""Finite and modal verbs, at which the description of a thing ends."""
DISMISSED = _patterns("dismissed")
"""Words before the thing that a self-correction withdraws: "not the can, the tin"."""
FILLERS, REPAIRS, EMPHASIS = _patterns("fillers"), _patterns("repairs"), _set("emphasis")
"""Filler words without meaning, words that announce a self-correction, and emphasis before a preposition, such as "right"."""
NONE, EXCEPT, CONTRAST = _patterns("none"), _patterns("except"), _patterns("contrast")
"""Words before things for which a statement is denied ("none of"), that are excepted ("except"), or that are not meant ("rather than")."""
TOLD = frozenset({"is", "are", "'s", "was", "were", "lies", "stands", "sits", "hangs", "rests"})
"""Verbs that can state the present place or state of a thing."""
TOO, WILL_DO, NEEDS = _patterns("too"), _patterns("will do"), _patterns("needs")
"""Words after a thing that is also meant ("too"), remarks after a thing ("is fine", "is in the way"), and words before a requested
action in its "-ing" form ("needs")."""
ASIDE = _set("aside")
"""Adverbs of place, which count as names if a thing is called so."""
IS_NOT = _patterns("is not")
"""Words of denial between a thing and the state that it should not have, in a clause after a wish."""
SWAPPED, EXISTS = _patterns("swapped"), _patterns("exists")
"""Words after things that exchange their places, and words that introduce things that should exist ("there is")."""
HOLDS, REASONS = _patterns("holds"), _patterns("reasons")
"""Verbs between a place and the things that it should contain, and words that introduce a reason."""
CONDITIONS, PROVISOS = _patterns("conditions"), _patterns("provisos")
"""Words that introduce a condition of a request ("if"), and words that introduce an exception to it ("unless")."""
LASTING = _set("lasting")
"""Verbs that turn a condition into a request: "provided that it stays upright"."""
TENS: Mapping[str, int] = _TABLES["tens"]
"""Number word of an amount, such as "fifteen" -> the number."""
NUMBER = _patterns("number")
"""Words before the number in a thing's name: "number" of "can number 4"."""
PRELUDE = _set("prelude")
"""Words that announce requests: "here is what I want: ..."."""
ORIGIN, SWAP = _patterns("origin"), _patterns("swap")
"""Words for the former place of a thing ("where it was"), and verbs that ask two things to exchange places."""
TOWARD = _table("toward")
"""Prepositions that can only name a destination, not the present place of a thing: "into", "onto"."""
CALLED = _set("called")
"""Words before the proper name of a thing, such as "called"."""
PLACED = _set("placed")
"""Verb forms before a place that do not change the meaning of the preposition: "placed" of "placed on the tray"."""
NEGATIVE, CONDITIONAL = _set("negative"), _set("conditional")
PACKAGES = _set("packages")
"""Words for packages of products, which need not be part of their names: "the ketchup bottle", "a can of soup"."""
TECHNICAL = _set("technical")
"""Technical words in the names of model files, which people do not say, such as "geom"."""
FURNITURE = _set("furniture")
"""Nouns for supporting furniture, which are used for one another, such as "table" and "counter"."""
GENERAL = _set("general")
"""Nouns for anything that can be moved."""
ANYTHING: Words = (_TABLES["anything"],)
ENDS = _set("ends")
"""Words after a side that add no meaning: "end" of "the left end"."""
REGIONS = _set("regions")
"""Nouns for a region of a thing."""
PLAIN, LOW = _set("plain"), _set("low")
"""Words of region names that name no place of their own, such as "surface", and words for the region under a thing."""
INWARD = _set("inward")
"""Words that occur in prepositions for the inside of a thing, such as "in"."""
ROBOT, VIEWER = _set("robot"), _set("viewer")
"""Words for the robot, and for the observer, neither of which is a thing of the scene."""
SHADES: Mapping[str, str] = _by_word("shades")
"""Synonym of a colour word -> the colour word."""
MATERIALS: Mapping[str, str] = _TABLES["materials"]
"""Adjective of a material, such as "wooden" -> the noun."""
SUBSTANCES = frozenset(MATERIALS.get(word, word) for word in _set("substances"))
"""Materials, which say nothing of a thing whose material is not known."""
PATTERNS = _set("patterns")
"""Adjectives of pattern and gloss, which are known of a thing only if they are in its name."""
UNCOLOURED = _set("uncoloured")
"""Words within a phrase of colours that are no colour, such as "and" and "coloured"."""
AUXILIARY, STATIVE, LIGHT = _set("auxiliary"), _set("stative"), _set("light")
"""Auxiliary verbs, verbs that tell how things are, and small words that any part of a request may contain."""
WISHED, OBLIGING, PAST = _set("wished"), _set("obliging"), _set("past")
"""Words that express a wish, words that express a duty, and verbs in the past tense."""
PERSONS, POSSESSIVE = _set("persons"), _set("possessive")
"""Words for persons, such as "I" and "mum", and possessive pronouns."""
REASON, SUITS, INDIFFERENT = _patterns("reason"), _patterns("suits"), _patterns("indifferent")
"""Words that introduce a reason or purpose, phrases that something is good enough, and phrases that something does not matter."""
WHILE = _set("while")
"""Conjunctions that introduce a clause of time, place or condition, which has a subject of its own."""
JOINTS, OPENS, MATRIX = _set("joints"), _set("opens"), _set("matrix")
"""Words that join clauses, words that end the introduction of a request, and words that begin such an introduction: "it would help if"."""
PERFECT = _set("perfect")
"""Auxiliary verbs of the perfect tense."""
FORGETTING, ADVERSE = _set("forgetting"), _set("adverse")
"""Words whose denial makes a request ("do not forget to"), and words that turn a request into its opposite ("avoid")."""
LIMITING, ADVERBS, ABSTRACT, TIMED = _set("limiting"), _set("adverbs"), _set("abstract"), _set("timed")
"""Adverbs of degree and other words in "-ly" that are no adverbs of manner, further adverbs, nouns of time and manner, and prepositions
before these nouns."""
NARRATED, NARRATING, CLAUSAL, DEPENDENT = _set("narrated"), _set("narrating"), _set("clausal"), _set("dependent")
"""Verbs of stories in the past and in the present tense, words that join clauses, and words that introduce a dependent clause."""
ENDED, PREPOSED, DATED = _set("ended"), _set("preposed"), _set("dated")
"""Words that cannot be the last of a clause, prepositions before the subject of a clause, and words of time or frequency before it."""
PLEASED, EXCLAIMED = _set("pleased"), _patterns("exclaimed")
"""Adjectives that introduce a wish ("glad if"), and exclamations and comments between commas."""
PROVIDING, TITLES, INTENDED = _set("providing"), _set("titles"), _set("intended")
"""Words that begin a clause of condition, nouns before the numbers of a list ("step one"), and participles that still ask for something
("is meant to")."""
MODAL, RELATIVE = _set("modal verbs"), _set("relative pronouns")
"""Modal verbs that oblige or permit, and relative pronouns."""
SPEAKING, OBLIGATION = _set("speaking"), _set("obligation")
"""Verbs of speaking that may report a request, and words that express a duty or the future."""
ORIENTED = _set("oriented")
"""Words by which a clause of purpose states the orientation or alignment of a thing, such as "facing"."""
TOGETHER, ADDRESS = _patterns("together"), _set("address")
"""Words after things that should stand side by side, and nouns by which somebody is addressed."""
QUESTIONS, WITHIN, CENTRAL = _patterns("questions"), _patterns("within"), _patterns("central")
"""Questions and remarks that only point at a thing, words before the tolerated distance from a middle, and phrases for that middle after
the distance."""
DEICTIC, COPULAR, ASKING = _set("deictic"), _set("copular"), _set("asking")
"""Words before the subject of a comment, verbs that link a subject with its state, and verbs that begin a question."""
GOING = _patterns("going")
"""Words before a place to which the robot should go."""
DEGREE, POINTED = _patterns("degree"), _patterns("pointed")
"""Words before a state that a clause states and does not ask for ("half", "still"), and phrases that point at a thing ("over there")."""
SO_DOES = _patterns("so does")
"""Words before a further thing for which the same request holds: "and so does the mug"."""
UP_TO = _set("up to")
"""Words between the ends of a range of numbers."""
GROUPS = _set("groups")
"""Nouns for a group of things, such as "stack"."""
ERECT = _set("erect")
"""Verb forms with which "up" means an upright orientation: "stand it up"."""
APPOSED, IDENTIFIED, BASED = _patterns("apposed"), _patterns("identified"), _patterns("based")
"""Words before a further description of a thing just named, words before another name of it, and words after the lowest thing of a
stack."""
AMOUNTING = _set("amounting")
"""Words before a number with its unit, such as "by" and "roughly"."""
NOT_YET = Phrases("not | no longer | never | anywhere (but|except|other than)")
"""Denials in a request whose parts stand in any order."""
SOURCES = (("off",), ("out",), ("from",))
"""First words of the prepositions that name the place from which a thing is taken."""
DIRECTED = frozenset({"into", "onto", "off", "out", "from", "on_top_of"})
"""Prepositions that name the end of a motion with any verb."""
TELLING = frozenset({*SIDES, *ORDINALS, *SIZES}) | frozenset(COLOURS)
"""Words that distinguish one thing among several: sides, ordinals, sizes and colours."""
UNITS: Mapping[str, str] = _TABLES["units"]
VIEWS: Mapping[str, tuple[Words, ...]] = {name: _phrases(text) for name, text in _TABLES["views"].items()}
"""Name of a view -> the phrases for it."""
FUNCTION = frozenset({*SIDES, *ORDINALS, *SIZES} | {p[0] for p in (*BESIDE, *UNDER) if len(p) == 1})
"""Words for a position, an order or a size, unless they are the name of a thing."""
SMALL = STOPS | AUXILIARY | LIGHT | THE | ONE | EVERY | NEGATIVE | PERSONS | JOINTS | EXTRA | {*PRONOUNS, *NUMBERS, *SIDES}
"""Function words (auxiliaries, articles, pronouns, numbers, sides) and punctuation, which are never the full verb of a clause."""
HUES = frozenset(COLOURS) | frozenset(SHADES)
"""Words for colours."""
BINDING, ALONE = (tuple(map(frozenset, _table(name))) for name in ("binding", "alone"))
"""Combinations of signs that may change a goal, in any clause and in a clause that stands alone."""
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
