"""Words that motion designators use as parameter values, each with a sentence."""

from __future__ import annotations

from ..base.word import Word


class Stage(Word):
    """Values of the parameter "stage" of a linear motion: at which pose of a place, such as its stand-off, the
    motion ends."""

    BEFORE = "before", "the stand-off of the place"
    VIA = "via", "the last pose on the way from the stand-off; the tool stays where there is none"
    POSE = "pose", "the place itself"
    END = "end", "the end of the place's path"


class Fingers(Word):
    """Values of the parameter "to" of a gripper motion: how far the fingers open or close."""

    OPEN = "open", "as wide as there is room to let go, else as far as they open"
    SHUT = "shut", "on nothing"
    CLOSED = "closed", "on the thing at the place"
    PLACE = "place", "as wide as the place asks for"


class Tilt(Word):
    """Values of the parameter "to" of a tilting motion: whether it leads to the tilted end of a place's path, or
    back to its upright beginning."""

    TILTED = "tilted", "the end of the place's path"
    UPRIGHT = "upright", "the beginning of the place's path"


class Hang(Word):
    """Values of the parameter "to" of a swinging motion, which lets a held thing hang from the fingers or
    lays it down."""

    HANGS = "hangs", "lifted until it hangs from the fingers"
    LIES = "lies", "led down until it lies"


class ExpectedGrip(Word):
    """Values of the parameter "expect" of a gripper motion: whether an object has to stop the fingers."""

    OBJECT = "object", "an object stopped the fingers"
    NONE = "none", "no object stopped the fingers"
    ANY = "any", "either"


class ExpectedContact(Word):
    """Values of the parameter "expect" of a guarded motion: whether a contact has to end it."""

    CONTACT = "contact", "something was felt"
    ANY = "any", "either: felt, or gone to the end"
