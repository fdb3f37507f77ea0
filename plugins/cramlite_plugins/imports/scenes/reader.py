"""Reader of scene files: MJCF and URDF become things, with notes on parts that were left out."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from cramlite.model import ImportedScene, StatedJoint
from cramlite.plugin import UserError, hookimpl

if TYPE_CHECKING:
    from .bodies import Group
    from .things import Made

TAGS = {".xml": ("mujoco", "robot"), ".mjcf": ("mujoco",), ".urdf": ("robot",)}
KEPT = {"timestep": 0.002, "impratio": 1.0, "noslip_iterations": 0}
"""Physics options that a world of cramlite can hold, with MuJoCo's defaults; other values are those that a file states."""
LONGEST_STEP = 0.005
"""The longest time step that settings of the simulation allow [s]."""


@hookimpl
def read_scene(
    path: Path, packages: Mapping[str, Path], keyframe: str, joints: Mapping[str, StatedJoint]
) -> ImportedScene | None:
    """Read the scene in an MJCF or URDF file; None if it is no such file."""
    if path.suffix.lower() not in TAGS:
        return None
    if not path.is_file():
        raise UserError(f"There is no scene file '{path}'.")
    from .source import root_tag

    tag = root_tag(path)
    if tag not in TAGS[path.suffix.lower()]:
        raise UserError(f"{path}:1: a scene begins with <mujoco> (MJCF) or <robot> (URDF), this file with <{tag or 'nothing'}>.")
    return _read(path, packages, keyframe, joints)


def _read(path: Path, packages: Mapping[str, Path], keyframe: str, joints: Mapping[str, StatedJoint]) -> ImportedScene:
    from ...simulation.model.no_window import import_mujoco

    import_mujoco()
    from .bodies import grouped
    from .geoms import pose_of
    from .pegs import with_pegs
    from .source import read_source

    source = read_source(path, packages, keyframe)
    groups = grouped(source.model, source.data)
    notes = [*source.warnings, *groups.notes, *_not_kept(source.model)]
    try:
        made, said = _things(source, groups.groups, joints)
    except UserError as error:
        raise UserError(f"{path}:1: {error}.") from error
    if not made:
        raise UserError(f"{path}:1: the scene has no thing that collides; {'; '.join(notes + said) or 'its worldbody is empty'}.")
    made = with_pegs(made)
    made.sort(key=lambda m: (m.thing.movable, m.thing.joint is None))
    physics, stated = _physics(source.model)
    stands = {source.model.body(b).name: pose_of(source.data.xpos[b], source.data.xmat[b]) for b in groups.robots}
    return ImportedScene(
        tuple(replace(m.thing, notes=m.notes) for m in made), {m.thing.name: m.names for m in made}, physics,
        {m.thing.name: m.found for m in made}, (*notes, *said, *stated), {m.thing.name: m.carrier for m in made if m.carrier}, stands,
    )  # fmt: skip


def _things(source: Any, groups: tuple[Group, ...], joints: Mapping[str, StatedJoint]) -> tuple[list[Made], list[str]]:
    """Return all things of a scene file, and notes on bodies that do not become things."""
    from .geoms import collides
    from .things import make, make_of_world

    model, taken, notes = source.model, dict[str, str](), list[str]()
    made: list[Made] = []
    called = {g.root: model.body(g.root).name or f"body_{g.root}" for g in groups}
    solid = [g for g in groups if _solid(model, g)]
    notes += [f"'{called[g.root]}' has no shape that collides; left out" for g in groups if g not in solid]
    kinds = {g.root: g.kind for g in solid}
    names = {g.root: _named(called[g.root], taken, notes) for g in solid}
    for group in solid:
        parent = names.get(group.parent, "") if group.kind == "joint" and kinds.get(group.parent) != "free" else ""
        stated = next((j for pattern, j in joints.items() if fnmatchcase(names[group.root], pattern)), StatedJoint())
        found = make(source, group, names[group.root], parent, bool(parent) and not _apart(source, group), stated)
        if found is not None and group.kind == "joint":
            found = replace(found, carrier=names.get(group.parent, ""))
        if found is None:
            notes.append(f"'{names[group.root]}' has no shape that things can have; left out")
        else:
            made.append(found)
    for g in range(int(model.body_geomnum[0])):
        if collides(model, g):
            name = _named(model.geom(g).name or f"geom_{g}", taken, notes)
            found = make_of_world(source, g, name)
            made += [found] if found else []
            notes += [] if found else [f"'{name}' has no shape that things can have (a height field?); left out"]
    shown = sum(not collides(model, g) for g in range(model.ngeom))
    return made, notes + ([f"{shown} shape{'s' * (shown != 1)} without contacts, purely visual: left out"] if shown else [])


def _solid(model: Any, group: Group) -> bool:
    """Whether any shape of a group of bodies that are fixed to each other collides."""
    from .geoms import collides

    return any(collides(model, g) for g in range(model.ngeom) if int(model.geom_bodyid[g]) in group.bodies)


def _named(name: str, taken: dict[str, str], notes: list[str]) -> str:
    """A name that scenarios can write: a letter, then letters, digits and underscores."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    plain = plain if re.match(r"[A-Za-z]", plain) else f"thing_{plain}"
    while plain in taken or plain in ("world", "effector", "hand", "other_hand"):
        plain += "_2"
    taken[plain] = name
    if plain != name:
        notes.append(f"'{name}' is called '{plain}' here")
    return plain


def _apart(source: Any, group: Group) -> bool:
    """Whether contacts between jointed bodies and their mount are to be ignored.

    They are if the file excludes them, or if the two overlap at the start.
    """
    model, data = source.model, source.data
    both = [(a, b) for a in group.bodies for b in group.carrier]
    excluded = bool({_pair(*p) for a, b in both for p in ((a, b), (b, a))} & {int(s) for s in model.exclude_signature})
    geoms, around = ([g for g in range(model.ngeom) if int(model.geom_bodyid[g]) in bodies] for bodies in (group.bodies, group.carrier))
    if excluded or not any(_meet(model, a, b) for a in geoms for b in around):
        return True
    return any(_between(model, data.contact[c].geom, group) and data.contact[c].dist < -0.002 for c in range(data.ncon))


def _meet(model: Any, a: int, b: int) -> bool:
    """Whether MuJoCo lets two geoms collide, by their contype and conaffinity bits."""
    return bool(model.geom_contype[a] & model.geom_conaffinity[b] | model.geom_contype[b] & model.geom_conaffinity[a])


def _pair(a: int, b: int) -> int:
    return (a << 16) + b


def _between(model: Any, geoms: Any, group: Group) -> bool:
    bodies = {int(model.geom_bodyid[g]) for g in geoms}
    return bool(bodies & set(group.bodies)) and bool(bodies & set(group.carrier))


def _physics(model: Any) -> tuple[dict[str, float | int | str], list[str]]:
    """Return a scene's physics options that differ from MuJoCo's defaults, and notes on those that are not kept."""
    found: dict[str, float | int | str] = {k: getattr(model.opt, k) for k, usual in KEPT.items() if getattr(model.opt, k) != usual}
    notes: list[str] = []
    if int(model.opt.cone) == 1:
        found["cone"] = "elliptic"
    if float(found.get("timestep", 0.0)) > LONGEST_STEP:
        notes.append(f"timestep {found['timestep']} s is longer than {LONGEST_STEP} s, at which hands still hold; {LONGEST_STEP} s is used")
        found["timestep"] = LONGEST_STEP
    x, y, z = (float(v) for v in model.opt.gravity)
    if abs(x) + abs(y) + abs(z + 9.81) > 0.01:
        notes.append(f"gravity ({x:g}, {y:g}, {z:g}) is not kept; it is (0, 0, -9.81) here")
    if model.opt.density or model.opt.viscosity or any(model.opt.wind):
        notes.append("wind, density and viscosity of the air are not kept")
    return found, notes


def _not_kept(model: Any) -> Iterator[str]:
    """Yield notes on the parts of a MuJoCo model that a scene of cramlite leaves out, such as its actuators,
    sensors and cameras."""
    counts = {
        "actuators": model.nu, "tendons": model.ntendon, "equality constraints": model.neq, "sensors": model.nsensor,
        "flexible bodies": model.nflex, "explicit contact pairs": model.npair, "cameras": model.ncam,
    }  # fmt: skip
    for what, count in counts.items():
        if count:
            yield f"left out: {count} {what if count > 1 else what.removesuffix('s')}"
    if model.nkey:
        yield f"the file has keyframes: {', '.join(repr(model.key(k).name) for k in range(model.nkey))}; 'keyframe' names one to start in"
    if any(int(a) not in (0, 1) or int(b) not in (0, 1) for a, b in zip(model.geom_contype, model.geom_conaffinity, strict=True)):
        yield "contact bits beyond 0 and 1 are not kept: all that collides meets all else"
    if model.nexclude:
        yield f"{model.nexclude} exclusions of contacts are kept only between a body on a joint and the body that it is mounted in"
