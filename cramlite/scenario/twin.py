"""Twins: copies of the believed world with errors drawn from an error model; no plan knows these errors.

Each source of error has random numbers of its own, so that a source that is left out changes nothing of what the others draw.
Where things are, and how large: ``twin_places``.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.errors import UserError, nearest
from ..base.value import Value
from ..model.entity_name import thing_of
from ..model.twins.error_model import ErrorModel, declared
from ..model.twins.error_sources import Around
from ..model.twins.twin_drawing import Draw, Drawing
from ..model.world.thing import Thing
from ..model.world.world import Disturbance, World
from .twin_places import Sight, place

if TYPE_CHECKING:
    from ..model.belief import Relation
    from ..model.robot import Robot


class Twin(Value):
    """Twin of a believed world.

    Args:
        world: as it may really be.
        draws: the numbers that make it differ.
    """

    world: World
    draws: tuple[Draw, ...]


def draw_twin(
    world: World, relations: Iterable[Relation], robot: Robot, errors: ErrorModel, seed: int, sight: Sight | None = None
) -> Twin:
    """Draw a twin.

    Args:
        world, relations: as believed; ("hangs_on", thing, hanger) are the relations that matter.
        robot: of the first mount.
        seed: the same one gives the same twin.
        sight: of the camera that the belief comes from; None where poses are known.

    Raises:
        UserError: the error model names a thing that the world does not have.
    """
    names = [t.name for t in world.things]
    for name in errors.things:
        if name not in names:
            raise UserError(f"The errors of the twin are about '{name}', which is no thing of this world; {nearest(name, names)}.")
    draw = Drawing(errors.scale, seed)
    hangers = {thing: thing_of(place) for predicate, thing, place in relations if predicate == "hangs_on"}
    things = tuple(_made(t, errors, draw) for t in place(world, hangers, robot, errors, draw, sight))
    twin = replace(world, things=things, disturbance=Disturbance())
    for name, source in declared(type(errors)).items():
        if source.world is not None:
            twin = source.world(twin, getattr(errors, name), draw, Around(world, robot))
    return Twin(twin, tuple(draw.draws))


def _made(thing: Thing, errors: ErrorModel, draw: Drawing) -> Thing:
    """Return a thing after each source of error in an error model has changed it."""
    for name, source in declared(type(errors)).items():
        if source.thing is not None:
            thing = source.thing(thing, getattr(errors, name), draw)
    return thing
