"""Goals of drawn scenes, said in sentences, are understood as these goals; said of what is not there, they are refused."""

from __future__ import annotations

from typing import NamedTuple

import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite import Engine, NotUnderstood
from cramlite.interpretation.fluents import symbolic_world
from cramlite.model import Geom, Pose, RobotMount, Thing, World
from cramlite.planning.spoken_goals import understand

KNOWLEDGE = Engine().knowledge
KINDS = {"mug": "soma:Cup", "bowl": "soma:Bowl", "bottle": "soma:Bottle", "plate": "soma:Plate", "spoon": "soma:Spoon"}
COLOURS = {"red": (0.9, 0.1, 0.1, 1.0), "blue": (0.1, 0.2, 0.9, 1.0), "green": (0.1, 0.7, 0.2, 1.0)}
PLACES = {"tray": "cram:Tray", "basket": "cram:Basket"}
FORMS = (
    "put {0} {1} {2}", "please place {0} {1} {2}", "{0} should be {1} {2}", "could you set {0} {1} {2}?", "{1} {2} put {0}",
    "I want {0} {1} {2}", "pick up {0} and put it {1} {2}", "make sure that {0} is {1} {2}", "{0} must be moved {1} {2}",
)  # fmt: skip
WAYS = {"on": ("on", "onto", "on top of"), "in": ("in", "into", "inside")}


class Drawn(NamedTuple):
    """A world with things in a row from left to right, and each one's kind and colour."""

    world: World
    loose: tuple[tuple[str, str, str], ...]


@st.composite
def drawn(draw: st.DrawFn) -> Drawn:
    picked = draw(st.lists(st.tuples(st.sampled_from(sorted(KINDS)), st.sampled_from(sorted(COLOURS))), min_size=2, max_size=6))
    loose = tuple((f"{kind}_{k}", kind, colour) for k, (kind, colour) in enumerate(picked))
    things = [_thing(n, KINDS[kind], COLOURS[colour], (0.5, 0.6 - 0.2 * k, 0.05)) for k, (n, kind, colour) in enumerate(loose)]
    things += [_thing(n, c, (0.6, 0.6, 0.6, 1.0), (0.2, 0.3 - 0.6 * k, 0.02), fixed=True) for k, (n, c) in enumerate(PLACES.items())]
    return Drawn(World(tuple(things), (RobotMount("arm", "ur5e"),)), loose)


def _thing(name: str, type_: str, rgba: tuple[float, float, float, float], at: tuple[float, float, float], *, fixed: bool = False) -> Thing:
    return Thing(name, type_, Pose(at), (Geom("box", (0.03, 0.03, 0.03), rgba=rgba),), mass=None if fixed else 0.1)


def _said(loose: tuple[tuple[str, str, str], ...], k: int) -> str | None:
    """A description that is true of one thing alone; None where kind, colour and ends of the row do not tell it apart."""
    name, kind, colour = loose[k]
    same = [n for n, other, _ in loose if other == kind]
    if len(same) == 1:
        return f"the {kind}"
    if [c for _, other, c in loose if other == kind].count(colour) == 1:
        return f"the {colour} {kind}"
    return f"the leftmost {kind}" if name == same[0] else f"the {kind} on the right" if name == same[-1] else None


@given(drawn(), st.data())
@examples(200)
def test_a_goal_that_is_said_is_understood(scene: Drawn, data: st.DataObject) -> None:
    k = data.draw(st.integers(0, len(scene.loose) - 1))
    described, place = _said(scene.loose, k), data.draw(st.sampled_from(sorted(PLACES)))
    way = data.draw(st.sampled_from(sorted(WAYS)))
    sentence = data.draw(st.sampled_from(FORMS)).format(described, data.draw(st.sampled_from(WAYS[way])), f"the {place}")
    symbolic = symbolic_world(scene.world, KNOWLEDGE.taxonomy)
    if described is None:
        kind = scene.loose[k][1]
        with pytest.raises(NotUnderstood, match="may be"):
            understand(f"put the {kind} {way} the {place}", symbolic, KNOWLEDGE)
        return
    assert understand(sentence, symbolic, KNOWLEDGE).goals == (f"{scene.loose[k][0]} {way} {place}",)


@given(drawn(), st.data())
@examples(100)
def test_what_is_not_there_is_refused(scene: Drawn, data: st.DataObject) -> None:
    kind, colour = data.draw(st.sampled_from(sorted(KINDS))), data.draw(st.sampled_from(sorted(COLOURS)))
    if any((k, c) == (kind, colour) for _, k, c in scene.loose):
        kind, colour = "teapot", colour
    with pytest.raises(NotUnderstood):
        understand(f"put the {colour} {kind} on the tray", symbolic_world(scene.world, KNOWLEDGE.taxonomy), KNOWLEDGE)
