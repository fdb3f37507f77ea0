"""A scripted person demonstrates a task; physics decides whether it succeeds.

A script is a sequence of intentions (reach, grip, pull along the peg, carry). It knows where things are, as a person
who looks at them does, but nothing holds unless contacts and friction hold it. All variety (approach, speeds,
hesitation, detours, grip, height of release, tremor) comes from the seed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from msgspec.structs import replace

from cramlite.errors import UserError, nearest
from cramlite.geometry import Floats, Pose
from cramlite.rollout import Rollout
from cramlite.value import Value
from cramlite.world import Feature, Thing, World

from .compile import Compiled, compile_world
from .hand import OPENING, PINCH, TCP
from .person import Person

#: Room between the fingers beside the object before they close [m].
MARGIN = 0.012
#: The palm and wrist stay this far below the peg, and above a container's rim, measured from the tool's axis [m].
PALM = 0.05
#: The palm's edge stays above what an object stands on: half its 56 mm (hand.py), and 7 mm for tilt and drift [m].
FLOOR = 0.035
#: A varied demonstration that did not come off is made anew, so often at most.
ATTEMPTS = 5
#: Pad force for one metre of closing beyond contact [N/m]: half the finger actuator's gain (hand.py).
SQUEEZE = 10000.0


class Scene(Value):
    """What the person sees: an object with a hole, a peg, and where the object goes to, or stands at the start.

    Args:
        container, cavity: the container that the object goes into and its opening; for an object that stands at the
            start, the thing below it and that thing's top.
    """

    world: World
    product: Thing
    hole: Feature
    hanger: Thing
    peg: Feature
    container: Thing
    cavity: Feature

    @property
    def along(self) -> Floats:
        """Unit vector along the peg, out of the wall, world axes."""
        return self.hanger.pose.turn(self.peg.pose.turn((0, 0, 1)))

    @property
    def facing(self) -> Floats:
        """Where the hand comes from: out of the object's front if it stands, else along the peg it hangs on."""
        return self.product.pose.turn(self.hole.pose.turn((0, 0, 1))) if self.stands else self.along

    @property
    def stands(self) -> bool:
        """Whether the object stands on something at the start."""
        return self.cavity.type != "cram:Cavity"


def demonstrate(world: World, *, seed: int, script: str = "take_off_hanger", rate: float = 50.0) -> Rollout:
    """Record a person who performs a script in a world.

    Args:
        world: with the things that the script needs; robots are left out.
        seed: of everything that varies between two demonstrations.
        script: one of ``SCRIPTS``.
        rate: samples a second.

    Returns:
        The recording, whatever came of it.

    Raises:
        UserError: there is no such script, or the world lacks what it needs.
    """
    if script not in SCRIPTS:
        raise UserError(f"there is no script '{script}' for a demonstration; {nearest(script, SCRIPTS)}")
    chosen = SCRIPTS[script]
    scene = chosen.see(world)
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, attempt] if attempt else seed)
        person = perform(scene, chosen.act, rng, rate, both=chosen.both_hands)
        if chosen.done is None or chosen.done(person, scene):
            break
    return chosen.after(person.rollout(), scene, rng) if chosen.after else person.rollout()


def perform(scene: Scene, act: Act, rng: np.random.Generator, rate: float, *, both: bool = False) -> Person:
    """Somebody who did it once.

    Args:
        both: they have two hands.
    """
    from .both_hands import from_above

    grasp = _grasp(scene, rng)
    hands = [grasp, *([from_above(scene.product.pose, scene.product)] if both else [])]
    rests = tuple(Pose((0, 0, 0), h.quaternion) for h in hands)
    compiled = compile_world(replace(scene.world, robots=()), {}, hand=rests)
    person = _beginning(compiled, scene, grasp, rng, rate)
    act(person, scene, grasp)
    return person


def _scene(world: World) -> Scene:
    """Find the object, the peg that it hangs on, and the container, by their features."""
    holed, pegs, cavities = (
        featured(world, "vrps:Hole", movable=True),
        featured(world, "vrps:Peg"),
        featured(world, "cram:Cavity"),
    )
    pairs = [(_off_axis(p, h), p, h) for p in holed for h in pegs]
    distance, product, peg = min(pairs, key=lambda c: c[0])
    if distance > 0.02:
        raise UserError(
            f"nothing hangs on a peg: the hole of '{product[0].name}' is {distance * 1000:.0f} mm off the peg of "
            f"'{peg[0].name}'; place the product with its hole around the peg"
        )
    return Scene(world, *product, *peg, *cavities[0])


def featured(world: World, type_: str, *, movable: bool = False) -> list[tuple[Thing, Feature]]:
    """Everything with a feature of a class, with that feature.

    Raises:
        UserError: there is nothing of the kind.
    """
    found = [(t, f) for t in world.things for f in t.features if f.type == type_ and (t.movable or not movable)]
    if not found:
        names = ", ".join(f"{t.name} ({t.type})" for t in world.things) or "none"
        what = f"{'movable ' if movable else ''}thing with a {type_}"
        raise UserError(f"the demonstration needs a {what}, and the world has none; its things are: {names}")
    return found


def _off_axis(product: tuple[Thing, Feature], hanger: tuple[Thing, Feature]) -> float:
    """Distance of a hole's centre from a peg's straight part [m]."""
    hole = product[0].pose.apply(product[1].pose.position)
    x, y, z = (hanger[0].pose * hanger[1].pose).inverse().apply(hole)
    beyond = max(-z, 0.0, z - hanger[1].size.get("length", 0.1))
    return math.hypot(x, y, beyond)


def _grasp(scene: Scene, rng: np.random.Generator) -> Pose:
    """Where the hand will close, in the product's frame at the start, given in the world: from the front, across the
    product's width, turned and tilted as it happens, low enough for palm and wrist to pass under the peg."""
    half = half_extents(scene.product)
    top = scene.hole.pose.position[2] - PALM - 0.02
    height = min(rng.uniform(-0.25, 0.25) * half[2], top)
    tilt, yaw, roll = rng.normal(0, [0.10, 0.06, 0.05])
    if scene.stands:  # palm and wrist stay above what it stands on
        height, tilt = max(height, FLOOR - half[2]), abs(tilt)
    front = scene.product.pose.inverse().turn(-scene.facing)
    level = Pose.from_axes((0, 0, height), front, (0, 0, -1))
    offset = np.array(level.position) + rng.uniform(-0.15, 0.15) * half[1] * np.array(front)
    turned = Pose((0, 0, 0), level.quaternion) * Pose.from_rotvec((0, 0, 0), (yaw, tilt, roll))
    return scene.product.pose * Pose(tuple(offset), turned.quaternion)


def half_extents(thing: Thing) -> Floats:
    """Half side lengths of a thing's body, without its features."""
    boxes = [g for g in thing.geoms if not g.part] or list(thing.geoms)
    reach = [np.abs(g.pose.position) + np.abs(g.pose.rotation) @ _half(g.shape, g.size) for g in boxes]
    return np.asarray(np.max(reach, axis=0))


def _half(shape: str, size: tuple[float, ...]) -> Floats:
    if shape == "box":
        return np.array(size)
    radius, length = size[0], size[1] if len(size) > 1 else 0.0
    return np.array([radius, radius, length + (radius if shape == "capsule" else 0.0) or radius])


def _beginning(compiled: Compiled, scene: Scene, grasp: Pose, rng: np.random.Generator, rate: float) -> Person:
    """A person whose hands touch nothing yet.

    Raises:
        UserError: there is no room for the hand in front of the object.
    """
    from .both_hands import waiting

    for _ in range(50):
        starts = [_start(scene, grasp, rng), *([waiting(scene, rng)] if compiled.other_hand else [])]
        person = Person(compiled, rng, starts, rate)
        if not any(name.startswith("effector/") for pair in compiled.collisions(person.data) for name in pair):
            return person
    raise UserError(f"there is no room for a hand in front of '{scene.product.name}'; move what stands there")


def _start(scene: Scene, grasp: Pose, rng: np.random.Generator) -> Pose:
    """Somewhere in front of the shelf, at ease, turned a little."""
    side = np.cross(scene.facing, (0, 0, 1))
    place = np.array(grasp.position) + scene.facing * rng.uniform(0.22, 0.35)
    sideways, up = rng.uniform(-0.2, 0.2), rng.uniform(-0.12, 0.08)
    place += side * sideways + np.array([0, 0, abs(up) if scene.stands else up])
    return Pose(tuple(place), (grasp * Pose.from_rotvec((0, 0, 0), rng.normal(0, 0.2, 3).tolist())).quaternion)


def take_off_hanger(person: Person, scene: Scene, grasp: Pose) -> None:
    """Take the object off the peg and put it into the container."""
    reach(person, scene, grasp)
    close(person, extent(scene, grasp))
    pull_off(person, scene)
    carry(person, scene)
    let_go(person, scene)


def reach(person: Person, scene: Scene, grasp: Pose) -> None:
    """Come from where the hand is, by a detour, to in front of the object; hesitate; approach."""
    person.grip(max(extent(scene, grasp) + 2 * MARGIN, person.between(0.08, OPENING)), 0.2)
    away = grasp.position + grasp.turn((0, 0, -person.between(0.07, 0.12)))
    before = Pose(tuple(away), grasp.quaternion)
    middle = np.add(person.aim.position, away) / 2 + person.rng.normal(0, 0.03, 3)
    person.move([Pose(tuple(middle)), before], person.between(0.2, 0.4), curved=True)
    if person.rng.random() < 0.5:
        person.wait(person.between(0.15, 0.6))
    person.move([grasp], person.between(0.08, 0.18))


def extent(scene: Scene, grasp: Pose) -> float:
    """What the fingers must enclose: the object's extent along the closing axis."""
    axis = np.abs(scene.product.pose.inverse().turn(grasp.turn((0, 1, 0))))
    half = half_extents(scene.product)
    return float(min(2 * half[int(np.argmax(axis))], OPENING))


def close(person: Person, width: float) -> None:
    """Pinch with a force between half and nearly all of what the fingers have."""
    force = person.between(0.5, 0.9) * PINCH
    person.grip(max(width - 2 * force / SQUEEZE, 0.0), person.between(0.4, 0.8))
    person.wait(person.between(0.15, 0.4))


def pull_off(person: Person, scene: Scene) -> None:
    """Lift until the peg is in the middle of the hole, then lead the hole along the peg and over its tip."""
    peg = scene.hanger.pose * scene.peg.pose
    hole = person.pose(scene.product.name) * scene.hole.pose
    x, y, depth = peg.inverse().apply(hole.position)
    centred = np.array(hole.position) - peg.turn((x, y, 0))
    end = peg.apply((0, 0, max(scene.peg.size["length"], depth)))
    route = [centred, end, *tip_points(scene), tip_points(scene)[-1] + scene.along * person.between(0.05, 0.09)]
    lead(person, scene, route[:1], 0.03)
    lead(person, scene, route[1:], person.between(0.07, 0.16))


def tip_points(scene: Scene) -> list[Floats]:
    """Where a bent tip leads: its end; the peg's own end where it has none."""
    tip = scene.hanger.feature("vrps:Tip")
    if tip is not None:
        return [scene.hanger.pose.apply(tip.pose.position)]
    return [scene.hanger.pose.apply(scene.peg.pose.apply((0, 0, scene.peg.size["length"])))]


def lead(person: Person, scene: Scene, route: list[Floats], speed: float) -> None:
    """Move the hole along points; the hand keeps its orientation. The person sees where the hole is in the hand."""
    hole = np.array((person.pose(scene.product.name) * scene.hole.pose).position)
    offset = np.array(person.tool().position) - hole
    person.move([Pose(tuple(p + offset), person.aim.quaternion) for p in route], speed)


def carry(person: Person, scene: Scene) -> None:
    """Over the container, by an arc, tilting the hand as it comes."""
    opening = scene.container.pose * scene.cavity.pose
    inner = np.array([scene.cavity.size[k] for k in ("width", "depth")])
    spot = opening.apply((*(person.rng.uniform(-0.12, 0.12, 2) * inner), 0.0))
    held = np.array(person.tool().position)
    body = np.array(person.pose(scene.product.name).position)
    low = body[2] - half_extents(scene.product)[2]
    above = np.array(
        [*(spot[:2] + held[:2] - body[:2]), max(opening.position[2] + held[2] - low, opening.position[2] + PALM)]
    )
    above[2] += person.between(0.03, 0.08)
    middle = (held + above) / 2 + np.array([*person.rng.normal(0, 0.03, 2), abs(person.rng.normal(0.05, 0.03))])
    turned = Pose((0, 0, 0), person.aim.quaternion) * Pose.from_rotvec(
        (0, 0, 0), person.rng.normal(0, 0.12, 3).tolist()
    )
    person.move([Pose(tuple(middle)), Pose(tuple(above), turned.quaternion)], person.between(0.2, 0.4), curved=True)
    if person.rng.random() < 0.4:
        person.wait(person.between(0.1, 0.5))


def _below(tool: Pose) -> float:
    """How far palm and wrist reach below the tool's origin when it is tilted."""
    return PALM + max(0.0, -float(tool.turn((0, 0, -(TCP + 0.08)))[2]))


def let_go(person: Person, scene: Scene) -> None:
    """Lower as far as palm and rim allow, or not quite so far; open; withdraw; wait until all is quiet."""
    rim = (scene.container.pose * scene.cavity.pose).position[2]
    x, y, z = person.aim.position
    lowest = rim + _below(person.aim) + person.between(0.0, 0.04)
    if z > lowest:
        person.move([Pose((x, y, lowest), person.aim.quaternion)], person.between(0.08, 0.2))
    person.wait(person.between(0.05, 0.3))
    person.grip(OPENING, person.between(0.25, 0.5))
    back = person.aim.position + person.aim.turn((0, 0, -(TCP - 0.02)))
    person.move([Pose((*back[:2], z + person.between(0.05, 0.1)), person.aim.quaternion)], person.between(0.15, 0.3))
    person.wait(1.0)


Act = Callable[[Person, Scene, Pose], None]


class Script(Value):
    """What a demonstration consists of.

    Args:
        see: what the person makes out in the world.
        act: how they move, given where the hand will close.
        done: whether it came off; people throw a recording away in which they dropped the thing, and make another.
        after: what the recorder makes of it.
        both_hands: the person has two.
    """

    see: Callable[[World], Scene]
    act: Act
    done: Callable[[Person, Scene], bool] | None = None
    after: Callable[[Rollout, Scene, np.random.Generator], Rollout] | None = None
    both_hands: bool = False


def _see_standing(world: World) -> Scene:
    from .hanging import see

    return see(world)


def _hang(person: Person, scene: Scene, grasp: Pose) -> None:
    from .hanging import hang_onto_hanger

    hang_onto_hanger(person, scene, grasp)


def _fetch_varied(person: Person, scene: Scene, grasp: Pose, *, distracted: bool = False) -> None:
    from .variety import fetch

    fetch(person, scene, grasp, distracted=distracted)


def _hang_varied(person: Person, scene: Scene, grasp: Pose, *, distracted: bool = False) -> None:
    from .variety import hang

    hang(person, scene, grasp, distracted=distracted)


def _in_container(person: Person, scene: Scene) -> bool:
    from .variety import in_container

    return in_container(person, scene)


def _on_peg(person: Person, scene: Scene) -> bool:
    from .variety import on_peg

    return on_peg(person, scene)


def _recorded(rollout: Rollout, scene: Scene, rng: np.random.Generator) -> Rollout:
    from .variety import recorded

    return recorded(rollout, scene, rng)


#: Scripts by name.
SCRIPTS: Mapping[str, Script] = {
    "take_off_hanger": Script(_scene, take_off_hanger),
    "hang_onto_hanger": Script(_see_standing, _hang),
    "take_off_hanger_varied": Script(_scene, _fetch_varied, _in_container, _recorded),
    "hang_onto_hanger_varied": Script(_see_standing, _hang_varied, _on_peg, _recorded),
    "take_off_hanger_distracted": Script(
        _scene, partial(_fetch_varied, distracted=True), _in_container, _recorded, both_hands=True
    ),
    "hang_onto_hanger_distracted": Script(
        _see_standing, partial(_hang_varied, distracted=True), _on_peg, _recorded, both_hands=True
    ),
}
