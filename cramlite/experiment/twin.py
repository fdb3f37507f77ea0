"""The twin: the world as it really is, drawn from a seed around the believed one; no plan knows it.

It is written into the world file that another process is given beside a program's text.

Sizes are half-widths: displacements are uniform in a ball of radius ``position``, turns uniform between -``angle`` and
+``angle``, shares uniform between 1 - x and 1 + x, displacements of links uniform on a sphere.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace
from pydantic import BaseModel, ConfigDict, Field

from ..base.errors import UserError, nearest
from ..base.quantities import Angle, Length
from ..model.geometry import Pose, Vector3
from ..model.world import Disturbance, Geom, Thing, World

if TYPE_CHECKING:
    from ..plugin.protocols import ModelMaker
    from ..scenario.scenario import HangSpec, Scenario


class _Spec(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class OffSpec(_Spec):
    """Pose error of a thing against the believed pose: in position [m], turned about the vertical [rad].

    What hangs on a thing moves along with it. A thing that hangs is displaced along its peg only, and turned about it: it
    goes on to hang.
    """

    thing: str
    position: Length = Field(default=0.0, ge=0.0)
    angle: Angle = Field(default=0.0, ge=0.0)


class TwinSpec(_Spec):
    """Ranges of the differences between a twin and the believed world.

    ``friction`` and ``mass`` are shares (0.1 is 10 %), of every thing and of the pads; ``force_noise`` [N] and
    ``force_drift`` [N/s] are of the wrist sensor, ``kinematics`` [m] is how far the flange is off where all links add up.
    """

    things: tuple[OffSpec, ...] = ()
    friction: float = Field(default=0.0, ge=0.0, lt=1.0)
    mass: float = Field(default=0.0, ge=0.0, lt=1.0)
    force_noise: float = Field(default=0.0, ge=0.0)
    force_drift: float = Field(default=0.0, ge=0.0)
    kinematics: Length = Field(default=0.0, ge=0.0)


def twin(
    scenario: Scenario, world: World, spec: TwinSpec, models: Mapping[str, ModelMaker], seed: int, joints: int
) -> World:
    """Draw a twin: a world as it may really be.

    Args:
        world: as believed.
        models: object models by name: they know how their things hang.
        seed: the same one gives the same twin.
        joints: of the first robot.

    Raises:
        UserError: the world has no thing of a name.
    """
    import numpy as np

    rng = np.random.default_rng([seed, 79])
    moved = _moved(scenario, world, spec.things, models, rng)
    things = tuple(_rubbed(replace(t, pose=moved.get(t.name, t.pose)), spec, rng) for t in world.things)
    physics = replace(world.physics, pad_friction=world.physics.pad_friction * _share(spec.friction, rng))
    disturbance = Disturbance(
        force_noise=spec.force_noise,
        force_drift=_ball(spec.force_drift, rng),
        links=tuple(_sphere(spec.kinematics / joints**0.5, rng) for _ in range(joints)) if joints else (),
    )
    return replace(world, things=things, physics=physics, disturbance=disturbance)


def _moved(
    scenario: Scenario, world: World, offs: Iterable[OffSpec], models: Mapping[str, ModelMaker], rng: Any
) -> dict[str, Pose]:
    """Where the things really are, those that others hang on first."""
    hanging = {t.name: t.hangs_on for t in scenario.spec.things if t.hangs_on}
    makers = {t.name: models[t.model] for t in scenario.spec.things}
    known, names = {o.thing: o for o in offs}, [t.name for t in world.things]
    for name in known:
        if name not in names:
            raise UserError(
                f"The twin displaces '{name}', which is no thing of '{scenario.name}'; {nearest(name, names)}."
            )
    found: dict[str, Pose] = {}
    for thing in world.things:  # a thing stands behind what it hangs on
        off = known.get(thing.name, OffSpec(thing=thing.name))
        if thing.name in hanging:
            hang = hanging[thing.name]
            hanger = world.thing(hang.hanger)
            below = replace(hanger, pose=found[hang.hanger])
            found[thing.name] = _hung(thing, below, hang, off, makers[thing.name], rng)
        else:
            found[thing.name] = _displaced(thing, off, rng)
    return found


def _hung(thing: Thing, hanger: Thing, hang: HangSpec, off: OffSpec, maker: ModelMaker, rng: Any) -> Pose:
    depth = hang.depth + float(rng.uniform(-1, 1)) * off.position
    yaw = hang.yaw + float(rng.uniform(-1, 1)) * off.angle
    assert maker.hung is not None  # else the believed world could not have been built
    return maker.hung(thing, hanger, depth, yaw)


def _displaced(thing: Thing, off: OffSpec, rng: Any) -> Pose:
    """What stands stays on what it stands on; what is fixed is off in every direction."""
    x, y, z = _ball(off.position, rng)
    turn = Pose.from_rotvec((0, 0, 0), (0, 0, float(rng.uniform(-1, 1)) * off.angle))
    px, py, pz = thing.pose.position
    rotated = turn * Pose((0, 0, 0), thing.pose.quaternion)
    return Pose((px + x, py + y, pz + (0.0 if thing.movable else z)), rotated.quaternion)


def _rubbed(thing: Thing, spec: TwinSpec, rng: Any) -> Thing:
    share, heavier = _share(spec.friction, rng), _share(spec.mass, rng)
    geoms = tuple(_geom(g, share) for g in thing.geoms)
    mass = None if thing.mass is None else thing.mass * heavier
    return replace(thing, geoms=geoms, friction=thing.friction * share, mass=mass)


def _geom(geom: Geom, share: float) -> Geom:
    return geom if geom.friction is None else replace(geom, friction=geom.friction * share)


def _share(size: float, rng: Any) -> float:
    return 1.0 + size * float(rng.uniform(-1, 1))


def _sphere(radius: float, rng: Any) -> Vector3:
    way = rng.normal(size=3)
    x, y, z = (radius * way / (way @ way) ** 0.5).tolist()
    return (x, y, z)


def _ball(radius: float, rng: Any) -> Vector3:
    x, y, z = _sphere(radius, rng)
    share = float(rng.uniform()) ** (1 / 3)
    return (share * x, share * y, share * z)
