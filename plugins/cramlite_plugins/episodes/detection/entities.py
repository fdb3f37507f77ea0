"""Semantic map of a world: its things, their parts and features, and the effector, as entities."""

from __future__ import annotations

from msgspec.structs import replace

from cramlite.model import Entity, EntityName, Feature, Geom, Pose, Rollout, Thing, Vector3

from ...shapes.bounds import extents

#: Degrees of freedom that a feature takes from what it carries: a peg, or its tip, in a hole leaves sliding
#: along it and turning about it; a surface stops motion in one direction (the rule of PickingUp).
CONSTRAINED_DOF = {"vrps:Peg": 4.0, "vrps:Hook": 4.0, "vrps:Tip": 4.0, "vrps:SurfaceFeature": 1.0}


def thing_entities(thing: Thing, rollout: Rollout) -> tuple[Entity, ...]:
    """Return the entities of a thing: itself, its features, and the parts that its geoms name and that are no
    features."""
    properties = {"friction": thing.friction} | ({} if thing.mass is None else {"mass": thing.mass})
    if thing.joint is not None:
        properties |= {"joint_lower": thing.joint.lower, "joint_upper": thing.joint.upper}
        properties |= {"joint_closed": thing.joint.closed} if thing.joint.closed > thing.joint.lower else {}
    if not any(CONSTRAINED_DOF.get(f.type, 0.0) > 1.0 for f in thing.features):
        properties["constrained_dof"] = 1.0
    whole = Entity(
        thing.name, (thing.type,), None, _initial(thing, rollout), _size(thing.geoms), thing.geoms, properties
    )
    features = tuple(_feature(thing, f) for f in thing.features)
    parts = sorted({g.part for g in thing.geoms if g.part} - {f.name for f in thing.features})
    return (whole, *features, *(_feature(thing, Feature(p, "soma:Feature")) for p in parts))


def effectors(rollout: Rollout) -> tuple[str, ...]:
    """Return the name of the acting hand or gripper, then those of all other hands with finger tips, such as
    a person's second hand."""
    tipped = {n.thing for n in map(EntityName.parse, rollout.poses) if n.part == "left"}
    return (rollout.effector, *sorted(tipped - {"effector", rollout.effector}))


def effector_entities(rollout: Rollout) -> tuple[Entity, ...]:
    """Return the entities of the hand or gripper that acts, of a person's other hand, and of their finger tips."""
    hand = rollout.joints.ndim < 2 or rollout.joints.shape[1] == 0
    types = ("soma:Hand", "soma:PrehensileEffector") if hand else ("soma:Gripper", "soma:PrehensileEffector")
    found = []
    for name in effectors(rollout):
        frame = "effector" if name == rollout.effector else name
        tips = [f for f in ("left", "right") if str(EntityName(frame, f)) in rollout.poses]
        found += [Entity(name, types), *(_finger(name, tip, rollout.sizes.get(str(EntityName(frame, tip)))) for tip in tips)]
    return tuple(found)


def _finger(hand: str, tip: str, pad: Vector3 | None) -> Entity:
    """Entity of a finger: its frame is in the middle of the pad, z towards the tip and x across the pad; the
    pad's size is a property if it is known."""
    known = {"pad_length": pad[2], "pad_width": pad[0]} if pad else {}
    return Entity(str(EntityName(hand, tip)), ("soma:Finger",), part_of=hand, properties=known)


def camera_entities(rollout: Rollout) -> tuple[Entity, ...]:
    """Return the entities of the cameras that were recorded; one on a flange is a part of the effector."""
    known = [c for c in rollout.world.cameras if c.name in rollout.poses]
    return tuple(Entity(c.name, ("cram:Camera",), c.mount, c.pose if c.mount is None else None) for c in known)


def contents_entities(rollout: Rollout) -> tuple[Entity, ...]:
    """Return the episode's entities for granular contents: one for each thing that was filled at the start."""
    return tuple(Entity(contents_of(thing), ("dul:Substance",)) for thing in rollout.grains)


def contents_of(thing: str) -> str:
    """Return the name that an episode gives to the loose contents which a thing held at the start."""
    return f"contents_of_{thing}"


def platform_entities(rollout: Rollout) -> tuple[Entity, ...]:
    """Return the entity of the robot's mobile base, if it has one."""
    name = str(EntityName(rollout.effector, "base"))
    known = name in rollout.poses
    return (Entity(name, ("cram:MobileBase",), rollout.effector, None, rollout.sizes.get(name)),) if known else ()


def _size(geoms: tuple[Geom, ...]) -> Vector3 | None:
    return extents(geoms) if geoms else None


def _initial(thing: Thing, rollout: Rollout) -> Pose | None:
    if thing.name in rollout.seen:
        return None  # nobody knew; its track begins when a camera sees it
    row = rollout.poses[thing.name][0] if thing.name in rollout.poses else None
    return thing.pose if row is None else Pose.from_row(row)


def _feature(thing: Thing, feature: Feature) -> Entity:
    inverse = feature.pose.inverse()
    geoms = tuple(replace(g, pose=inverse * g.pose) for g in thing.geoms if g.part == feature.name)
    properties = dict(feature.size)
    if feature.type in CONSTRAINED_DOF:
        properties["constrained_dof"] = CONSTRAINED_DOF[feature.type]
    return Entity(
        str(EntityName(thing.name, feature.name)), (feature.type,), thing.name, feature.pose, _size(geoms), geoms, properties
    )
