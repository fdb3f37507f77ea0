"""Plugin of libraries of object models: ``cramlite library add`` makes them, scenarios and queries read them."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import json
from msgspec.structs import replace

from cramlite.model import BuiltLibrary, KnownKind
from cramlite.plugin import ModelMaker, UserError, hookimpl

if TYPE_CHECKING:
    from .entries import Entry
    from .mjcf_kind import Draft

VERSION = 6
"""Version of the files of a library; another version makes its kinds anew."""
FILE = "library.yaml"


@hookimpl
def read_models(path: Path) -> Sequence[ModelMaker] | None:
    """Return makers of the object models of a library, given its folder or file; None if the path is no library."""
    file = path / FILE if path.is_dir() else path
    if file.name != FILE or not file.is_file():
        return None
    from .entries import read_entries
    from .makers import maker

    return [maker(name, entry, file.parent) for name, entry in read_entries(file).items()]


@hookimpl
def add_models(folder: Path, library: Path, scale: float, density: float, up: str) -> BuiltLibrary:
    """Add object models made from the files of a folder to a library; models whose files are unchanged are kept."""
    from ...simulation.model.no_window import import_mujoco

    import_mujoco()
    from .entries import read_entries, write_entries
    from .sources import sources

    file = library / FILE
    entries = dict(read_entries(file)) if file.is_file() else {}
    found, kinds, refused = sources(folder), list[KnownKind](), dict[str, str]()
    made: dict[str, Path] = {}
    for name, path in found.files:
        other = made.get(name) or _elsewhere(entries.get(name), path)
        if other is not None:
            refused[str(path)] = f"'{name}' is the name of '{other}', too; rename one of the files."
            continue
        try:
            kind, entry = _added(name, path, library, entries.get(name), (scale, density, up))
        except UserError as error:
            refused[str(path)] = " ".join(str(error).removeprefix(f"{path}:").split())
            continue
        made[name] = path
        entries[name] = entry
        kinds.append(kind)
    if kinds:
        write_entries(file, entries)
    return BuiltLibrary(tuple(kinds), refused, found.parts)


def _elsewhere(entry: Entry | None, path: Path) -> Path | None:
    """Return the file from which the library's model of this name was made before, if that is another file than
    ``path`` and still exists; else None."""
    before = Path(str(entry.told.get("file", path))) if entry is not None else path
    return before if before.resolve() != path.resolve() and before.is_file() else None


def _added(
    name: str, path: Path, library: Path, before: Entry | None, options: tuple[float, float, str]
) -> tuple[KnownKind, Entry]:
    """Add a file's object model to the library, which keeps one that was made from the same files and options."""
    digest = _digest(path, options)
    if before is not None and before.made_from == digest and all((library / f).is_file() for f in (before.thing, before.look)):
        return replace(json.decode(json.encode(before.told), type=KnownKind), kept=True), before
    draft = _draft(name, path, *options[:2])
    kind = _told(name, path, draft, options[2])
    library.mkdir(parents=True, exist_ok=True)
    from .entries import Entry, LooksSpec
    from .look import write
    from .parts import write_looks

    (library / f"{name}.json").write_bytes(json.encode(write_looks(draft.thing, draft.mesh, library)))
    write(draft.mesh, library / f"{name}.glb")
    told = json.decode(json.encode(kind))
    entry = Entry(thing=f"{name}.json", look=f"{name}.glb", type=draft.thing.type, fixed=draft.thing.mass is None,
                  up=options[2] or None, looks=LooksSpec(**told["looks"]), made_from=digest, told=told)  # fmt: skip
    return kind, entry


def _draft(name: str, path: Path, scale: float, density: float) -> Draft:
    if path.suffix.lower() in (".xml", ".mjcf"):
        from .mjcf_kind import from_mjcf

        return from_mjcf(path, name)
    from .mesh_kind import from_mesh

    return from_mesh(path, name, scale, density)


def _told(name: str, path: Path, draft: Draft, up: str) -> KnownKind:
    from .attitudes import said, upward
    from .looks import looks_of

    extents = tuple(round(float(v), 5) for v in draft.mesh.extents)
    guesses = upward(draft.mesh)
    guess = " or ".join(f"{said(u)} ({100 * s:.0f} %)" for u, s in guesses[:3])
    usual = f"{up}, as was said" if up else f"{guess}, by its shape"
    return KnownKind(name, str(path), extents, len(draft.mesh.faces), draft.printed, draft.thing.mass, draft.mass,  # type: ignore[arg-type]
                     draft.joints, usual, draft.notes, looks=looks_of(draft.mesh, up, loose=draft.thing.mass is not None))  # fmt: skip


def _digest(path: Path, options: tuple[float, float, str]) -> str:
    """Digest of the files that an object model may be made from: all in its folder, and for MJCF also
    those in subfolders."""
    whole = hashlib.sha256(f"{VERSION}|{options}|{path.name}".encode())
    beside = path.parent.rglob("*") if path.suffix.lower() in (".xml", ".mjcf") else path.parent.glob("*")
    for file in sorted(p for p in beside if p.is_file()):
        whole.update(f"|{file.relative_to(path.parent)}|{file.stat().st_size}|".encode())
        if file == path or file.stat().st_size < 20_000_000:
            whole.update(file.read_bytes())
    return whole.hexdigest()[:24]
