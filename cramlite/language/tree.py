"""Syntax tree of a sentence, before the scene is consulted: noun phrases, their relations, requests and statements."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base.value import Value

if TYPE_CHECKING:
    from ..interpretation.fluents import GoalPhrase
    from .english import Words


UTMOST = ("nearest", "farthest")
"""Relations that hold of the one thing of several of which they hold most."""


class Link(Value):
    """Relation of a noun phrase to others: "on the stove", "between the plate and the cup", "on the left".

    Args:
        relation: "phrase" (a preposition of goal phrases), "side" (a position among others), "of" (part and whole), "with" (the converse:
            "with the cup on it"), "under", "at" (on or in), "state" (an adjective), "except" (left out),
            "same" (another name), "comment" (says nothing),
            or one that is judged by positions.
        words: the preposition, or the word of the side or state.
        nouns: what it relates to.
        denied: whether it does not hold: "not between the plate and the cup".
    """

    relation: str
    words: Words
    nouns: tuple[Noun, ...] = ()
    denied: bool = False


class Noun(Value):
    """Noun phrase: a description of things.

    Args:
        said: as it was said.
        words: what they are called, without articles, numbers and positions.
        quantity: "the", "a", "all", "number", or "none".
        count: of "number".
        sides: positions among others, e.g. "left".
        ordinal: 1 for the first, -1 for the last; 0 without one.
        size: 1 the largest, -1 the smallest, 2 the tallest, -2 the lowest; 0 without one.
        elided: whether "one" stands for what it is called.
        other: whether things that were named before are left out.
        several: whether it is said in the plural.
        links: relations to others.
        pronoun: that stands for what was named before; "" for none.
        members: of "the cup and the plate"; else none.
        joined: "and" or "or", of these.
    """

    said: str
    words: Words = ()
    quantity: str = "the"
    count: int = 0
    sides: tuple[str, ...] = ()
    ordinal: int = 0
    size: int = 0
    elided: bool = False
    other: bool = False
    several: bool = False
    links: tuple[Link, ...] = ()
    pronoun: str = ""
    members: tuple[Noun, ...] = ()
    joined: str = ""

    @property
    def comments(self) -> tuple[str, ...]:
        """Remarks within the noun phrase that do not describe the thing."""
        own = tuple(" ".join(link.words) for link in self.links if link.relation == "comment")
        return own + tuple(c for n in (*self.members, *(n for link in self.links for n in link.nouns)) for c in n.comments)


class Clause(Value):
    """Clause of an English sentence that asks for something, or states something, about things.

    Args:
        said: its words, without those of its descriptions.
        phrases: goal phrases that it may mean, the likelier first.
        theme: what the goal is about.
        place: the second thing, for phrases that have one.
        relation: how the theme shall be to the place: "phrase", "swap" (the themes change places), or one that is judged by positions.
        words: the preposition.
        amount: with its unit; "" for none.
        beside: a further relation of the place: "on the table next to the plate".
        later: whether it is to be done after the ones before.
        denied: whether it shall not be so: "the tin should not be on the floor".
        told: whether it says how things are, as it seems: "the drawer is shut".
        paired: whether each theme has its own place: "respectively".
        given: whether it is a condition of the next request: "if the drawer is open".
        odd: a verb that is not known, of which the place or state tells the result.
        bare: whether no word tells how the theme shall be to the place: "can, tray".
        either: whether it will do in the place of the one before.
        state: how the theme shall be there, as a goal phrase of it alone: "put the cup upside down onto the tray".
    """

    said: str
    phrases: tuple[GoalPhrase, ...]
    theme: Noun
    place: Noun | None = None
    relation: str = "phrase"
    words: Words = ()
    amount: str = ""
    beside: Link | None = None
    later: bool = False
    denied: bool = False
    given: bool = False
    told: bool = False
    paired: bool = False
    state: GoalPhrase | None = None
    odd: str = ""
    bare: bool = False
    either: bool = False
