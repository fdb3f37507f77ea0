"""Words of motion designators for meanings rather than amounts, each with a sentence."""

from __future__ import annotations

from ..base.word import Word


class Stage(Word):
    """End of a linear motion to a place: "stage"."""

    BEFORE = "before", "the stand-off of the place"
    VIA = "via", "the last pose on the way from the stand-off; the tool stays where there is none"
    POSE = "pose", "the place itself"
    END = "end", "the end of the place's path"


class Fingers(Word):
    """Goal of a gripper motion: "to"."""

    OPEN = "open", "as wide as there is room to let go, else as far as they open"
    SHUT = "shut", "on nothing"
    CLOSED = "closed", "on the thing at the place"
    PLACE = "place", "as wide as the place asks for"


class Tilt(Word):
    """Goal of a tilt: "to"."""

    TILTED = "tilted", "the end of the place's path"
    UPRIGHT = "upright", "the beginning of the place's path"


class Hang(Word):
    """Goal of a swing: "to"."""

    HANGS = "hangs", "lifted until it hangs from the fingers"
    LIES = "lies", "led down until it lies"


class ExpectedGrip(Word):
    """End of a gripper motion that is no failure: "expect"."""

    OBJECT = "object", "an object stopped the fingers"
    NONE = "none", "no object stopped the fingers"
    ANY = "any", "either"


class ExpectedContact(Word):
    """End of a guarded motion that is no failure: "expect"."""

    CONTACT = "contact", "something was felt"
    ANY = "any", "either: felt, or gone to the end"
