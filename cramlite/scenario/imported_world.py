"""Things of a scenario that are read from a scene file such as an MJCF, with their classes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.errors import PluginError, UserError, nearest
from ..base.value import Value
from ..ontology.taxonomy import words_of
from .model_files import existing_file

if TYPE_CHECKING:
    from pathlib import Path

    from ..model.world.imported_scene import ImportedScene, StatedJoint
    from ..model.world.thing import Thing
    from ..ontology.taxonomy import Taxonomy
    from ..plugin.catalogue import Knowledge
    from .scenario import Scenario, WorldFileSpec


class Proposal(Value):
    """Proposed class of an imported thing.

    Args:
        type: as a CURIE.
        reason: why, as a clause.
    """

    type: str
    reason: str


def read_scene_file(
    path: Path, packages: Mapping[str, Path], keyframe: str, knowledge: Knowledge, joints: Mapping[str, StatedJoint] | None = None
) -> ImportedScene:
    """Read a scene file with the first plugin that knows its format.

    Args:
        joints: pattern of names of jointed things -> what is stated of their joints.

    Raises:
        UserError: no plugin does, or it cannot be used.
        PluginError: the one that should have read it failed.
    """
    given = {"path": path, "packages": packages, "keyframe": keyframe, "joints": joints or {}}
    scene: ImportedScene | None = knowledge.registry.first("read_scene", **given)
    if scene is None:
        nobody = f"'{path}' is in no format that a plugin reads as a scene (MJCF, URDF); see 'cramlite plugins'."
        failed = [str(f) for f in knowledge.registry.faults if f.hook == "read_scene"]
        raise PluginError(f"{nobody} Failed: {'; '.join(failed)}.") if failed else UserError(nobody)
    return scene


def imported_world(scenario: Scenario, knowledge: Knowledge) -> ImportedScene | None:
    """Read the scene file of a scenario's ``world``, give its things their classes, and leave out the excluded ones;
    None without such a file.

    Raises:
        UserError: the file, a class or a pattern cannot be used; with file and line.
    """
    spec = scenario.spec.world
    if spec is None:
        return None
    path = existing_file(scenario, spec.file, "scene", "world", "file")
    packages = {name: scenario.resolve_path(folder) for name, folder in spec.packages.items()}
    scene = read_scene_file(path, packages, spec.keyframe, knowledge, {n: j.stated() for n, j in spec.joints.items()})
    _check_patterns(scenario, spec, path.name, scene)
    types = {p: knowledge.taxonomy.known(c, scenario.where("world", "types", p)) for p, c in spec.types.items()}
    kept = [t for t in scene.things if not any(fnmatchcase(t.name, p) for p in spec.leave_out)]
    return replace(scene, things=tuple(_classed(t, scene, types, knowledge.taxonomy) for t in kept))


def _check_patterns(scenario: Scenario, spec: WorldFileSpec, file: str, scene: ImportedScene) -> None:
    """Check that each pattern for names of things in a scenario's ``world`` matches a thing of the scene file."""
    names, jointed = [t.name for t in scene.things], [t.name for t in scene.things if t.joint is not None]
    patterns: list[tuple[str, str | int, str]] = [("leave_out", k, p) for k, p in enumerate(spec.leave_out)]
    patterns += [*(("types", p, p) for p in spec.types), *(("joints", p, p) for p in spec.joints)]
    for key, at, pattern in patterns:
        which, called = ("jointed ", jointed) if key == "joints" else ("", names)
        if not any(fnmatchcase(n, pattern) for n in called):
            said = f"no {which}thing of '{file}' is called '{pattern}'; {nearest(pattern, called)}"
            raise UserError(f"{scenario.where('world', key, at)}: {said}.")


def _classed(thing: Thing, scene: ImportedScene, types: Mapping[str, str], taxonomy: Taxonomy) -> Thing:
    found = propose(thing, scene, types, taxonomy)
    said = f"taken for {found.type}, because {found.reason}; {scene.found.get(thing.name, '')}".rstrip("; ")
    return replace(thing, type=found.type, notes=(said, *thing.notes))


def propose(thing: Thing, scene: ImportedScene, types: Mapping[str, str], taxonomy: Taxonomy) -> Proposal:
    """Propose the class of an imported thing.

    A pattern of the scenario comes first, then the longest label of the ontology in its own name, then the one that at least half
    of the names of its parts have, then what its reader takes it for by how it moves. Words that a jointed thing shares
    with what it is mounted in say what that is: a cabinet's drawer is no cabinet.

    Args:
        scene: that it is of.
        types: pattern of names -> class.
    """
    for pattern, name in types.items():
        if fnmatchcase(thing.name, pattern):
            return Proposal(name, f"the scenario says so of '{pattern}'")
    shared = words_of(scene.mounts.get(thing.name, ""))
    own, *parts = ("_".join(w for w in words_of(n) if w not in shared) for n in (thing.name, *scene.names.get(thing.name, ())))
    if named := taxonomy.thing_named(own):
        return Proposal(named[0], f"'{thing.name}' contains the label '{named[1]}'")
    labels = Counter(named for name in parts if (named := taxonomy.thing_named(name)))
    if labels and 2 * (most := labels.most_common(1)[0])[1] >= len(parts):
        return Proposal(most[0][0], f"{most[1]} of the {len(parts)} names of its parts contain the label '{most[0][1]}'")
    how = "can be moved" if thing.joint is None and thing.movable else "is mounted on a joint" if thing.joint else "is fixed"
    return Proposal(thing.type, f"it {how} and its names contain no label of a class of the ontology")
