"""Check of a scene file before MuJoCo reads it: the files that it would open, and the memory that it would allocate.

MuJoCo itself opens any path, devices included, repeats elements as often as a file says, and crashes on a model that is attached to
itself (MuJoCo 4.0).
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path

from msgspec import Struct, field

from cramlite.plugin import UserError, check_file, check_xml

MOST_BYTES = 200_000_000
"""Largest size of a mesh or another file of a scene [bytes]: 200,000 faces, MuJoCo's limit, take 10 MB as STL and some 50 MB as OBJ."""
MOST_ELEMENTS, MOST_BODIES = 50_000, 2_000
"""Largest numbers of XML elements and of bodies, repeated ones counted each time: the largest kitchens of RoboCasa have some 10,000 and
500."""
MOST_CELLS = 2**24
"""Largest number of cells of a height field, of pixels of a texture, and of reserved sizes times elements: 128 MB."""
REPEATED = ("composite", "flexcomp", "replicate")
_MODELS = ("include", "model")
"""XML elements whose file is a part of the model; MuJoCo 4 unpacks archives that ``model`` names."""
_FILES = re.compile(r"file\w*")
_FOLDERS = ("assetdir", "meshdir", "texturedir")
_UNALLOCATED = ("nconmax", "njmax", "nstack")
"""Sizes in an MJCF file for which MuJoCo reserves memory without filling it."""


Weight = tuple[int, int]


class _Named(Struct):
    """Name of a file that a scene file contains, with its line, and whether the named file must be a part of
    a model."""

    path: Path
    line: int
    name: str
    part: bool


class _File(Struct):
    """Counts of the elements of a scene file, and the other files that it names, collected while the file is read.

    Args:
        times: how often what is read now is repeated, by each element around it.
        attached: attachments of other models.
        cells: of height fields, textures, made meshes and sensors.
        named: files that it names.
        folders: that it says meshes and pictures are in.
    """

    path: Path
    times: list[int] = field(default_factory=lambda: [1])
    elements: int = 0
    bodies: int = 0
    attached: int = 0
    sizes: int = 0
    cells: int = 0
    named: list[_Named] = field(default_factory=list)
    folders: list[str] = field(default_factory=list)

    def visit(self, line: int, name: str, attributes: Mapping[str, str] | None) -> None:
        if attributes is None:
            self.times.pop()
            return
        where = f"{self.path}:{line}"
        times = self.times[-1] * (_count(where, attributes.get("count", "1")) if name in REPEATED else 1)
        self.times.append(times)
        self.elements += times
        self.bodies += times * (name in ("body", "link", *REPEATED[:2]))
        self.attached += times * (name == "attach")
        self.folders += [attributes[k] for k in _FOLDERS if attributes.get(k)]
        files = [v for k, v in attributes.items() if _FILES.fullmatch(k) and v]
        self.named += [_Named(self.path, line, v, name in _MODELS) for v in files]
        _check_amount(where, self.elements, "elements", MOST_ELEMENTS)
        _check_amount(where, self.bodies, "bodies", MOST_BODIES)
        self.allocate(where, name, attributes)

    def allocate(self, where: str, name: str, attributes: Mapping[str, str]) -> None:
        """Add up the numbers for which MuJoCo would allocate memory because of an element of a scene file;
        refuse too many."""
        for one, other in (("nrow", "ncol"), ("width", "height")):
            if one in attributes or other in attributes:
                self.cells += _count(where, f"{attributes.get(one, 1)} {attributes.get(other, 1)}")
                _check_amount(where, self.cells, f"cells ({one} x {other})", MOST_CELLS)
        if name == "user":
            self.cells += _count(where, attributes.get("dim", "1"))
            _check_amount(where, self.cells, "cells (dim)", MOST_CELLS)
        if "builtin" in attributes and name == "mesh":  # MuJoCo bounds the subdivision of spheres alone
            points = max((_count(where, word) for word in attributes.get("params", "").split()), default=1) ** 2
            _check_amount(where, points, "points of a mesh (params squared)", MOST_ELEMENTS)
            self.cells += points
        if name == "size":
            self.sizes += sum(_count(where, v) for k, v in attributes.items() if k.startswith("n") and k not in _UNALLOCATED)
        _check_amount(where, self.sizes * self.elements, "numbers (sizes x elements)", MOST_CELLS)


def check_scene(path: Path, text: str, packages: Iterable[Path]) -> None:
    """Check a scene file and all files that it names.

    Args:
        text: of the file, as MuJoCo is given it.
        packages: folders beside its own that it may name files of.

    Raises:
        UserError: it is no XML, would take too much memory, includes itself, or names a file that is none, is too large, or is
            in no folder that it may read; with file and line.
    """
    read = _Read(Roots(path, tuple(packages)))
    _weight(path, text, read, (path.resolve(),))
    for named in read.named:  # once more: any file may say the folder of the meshes of all
        for file in _meant(named, read):
            if named.part and file not in read.known:
                _weigh_part(named, file, read, (path.resolve(),))


PACKAGES = ("package.xml", "__init__.py", ".git")
"""Names in the top folder of a ROS package, of a Python package such as a wheel of scenes, and of a repository."""


class Roots(Struct, dict=True):
    """Folders that a scene file may read: its own, those of the packages that it is in (``PACKAGES``), and stated ones.

    Args:
        path: of the scene file.
        stated: by the scenario or on the command line.
    """

    path: Path
    stated: tuple[Path, ...] = ()

    @cached_property
    def folders(self) -> tuple[Path, ...]:
        """Return the folders that files may be read from, symbolic links resolved."""
        around = self.path.resolve().parents
        packages = [folder for marker in PACKAGES for folder in [f for f in around if (f / marker).exists()][:1]]
        return (self.path.parent.resolve(), self.path.resolve().parent, *packages, *(folder.resolve() for folder in self.stated))

    def check(self, where: str, file: Path) -> None:
        """Refuse a file that is in none of the permitted folders, is no file, or is too large."""
        resolved = file.resolve()
        if not any(resolved.is_relative_to(folder) for folder in self.folders):
            raise UserError(
                f"{where}: '{file}' is outside of the scene's folder '{self.path.parent}', and of a package or repository around it. "
                "A scene may name files in these only. "
                "If this one should be read, say so: 'packages: {assets: FOLDER}' beside 'file' in a scenario, or "
                "'cramlite import' with --package assets=FOLDER."
            )
        try:
            check_file(file, MOST_BYTES)
        except UserError as error:
            raise UserError(f"{where}: {error}") from None


class _Read(Struct):
    """Content read from all files of a scene: weights of parts, named files, folders of meshes and
    pictures."""

    roots: Roots
    known: dict[Path, Weight] = field(default_factory=dict)
    named: list[_Named] = field(default_factory=list)
    folders: list[str] = field(default_factory=list)


def _weight(path: Path, text: str, read: _Read, around: tuple[Path, ...]) -> Weight:
    """Return the numbers of elements and bodies of a scene file, with those of all files that it includes and
    attaches."""
    here = _File(path)
    check_xml(path, text, here.visit)
    read.named += here.named
    read.folders += here.folders
    inner = [(0, 0)]
    for named in here.named:
        for file in _meant(named, read):
            if file.resolve() in around:
                raise UserError(f"{path}:{named.line}: '{named.name}' includes itself; take one 'include' or 'model' out.")
            inner.append(read.known[file] if file in read.known else _weigh_part(named, file, read, around))
    bodies = max(b for _, b in inner) * here.attached + sum(b for _, b in inner) + here.bodies
    elements = max(e for e, _ in inner) * here.attached + sum(e for e, _ in inner) + here.elements
    _check_amount(f"{path}:1", elements, "elements", MOST_ELEMENTS)
    _check_amount(f"{path}:1", bodies, "bodies", MOST_BODIES)
    return elements, bodies


def _weigh_part(named: _Named, file: Path, read: _Read, around: tuple[Path, ...]) -> Weight:
    """Count the elements and bodies of a file that a scene file names; (0, 0) for meshes and pictures."""
    content = _model(file, named.part)
    if named.part and content is not None and not content.lstrip("\ufeff \t\r\n").startswith("<"):
        raise UserError(
            f"{named.path}:{named.line}: '{named.name}' is no XML; MuJoCo would unpack it if it is an archive, and here parts of a model "
            "are XML files only. Unpack it, and name the file that was in it."
        )
    read.known[file] = (0, 0) if content is None else _weight(file, content, read, (*around, file.resolve()))
    return read.known[file]


def _meant(named: _Named, read: _Read) -> list[Path]:
    """Return the files to which a name in a scene file may refer, each checked for whether it may be read.

    They are beside the naming file or the scene, or in a folder of meshes or pictures.

    MuJoCo takes a backslash for a slash, and ``x/..`` away without a look at whether x is there, or is a link.
    """
    name = named.name.replace("\\", "/")
    folders = ["", *(folder.replace("\\", "/") for folder in read.folders)]
    bases = sorted({read.roots.path.parent, named.path.parent})
    found = [base / folder / n for base in bases for folder in folders for n in (name, Path(name).name)]
    written = [Path(named.path.parent / named.name)]
    meant = [f for f in dict.fromkeys((*found, *(Path(os.path.normpath(f)) for f in found), *written)) if _is_there(f)]
    for file in meant:
        read.roots.check(f"{named.path}:{named.line}", file)
    return meant


def _is_there(file: Path) -> bool:
    try:
        return file.exists() and not file.is_dir()
    except (OSError, ValueError):  # a name too long, or with a zero
        return False


def _model(file: Path, part: bool) -> str | None:
    """The text of a file that is a part of a model; None for meshes and pictures."""
    with file.open("rb") as opened:
        if not part and b"<mujoco" not in opened.read(100_000) and file.suffix.lower() not in (".xml", ".mjcf", ".urdf"):
            return None
    return file.read_text(encoding="utf-8", errors="replace")


def _count(where: str, text: str) -> int:
    """Return the product of the integers in an attribute of an XML element."""
    product = 1
    for word in text.split():
        try:
            product *= max(int(float(word)), 1)
        except (ValueError, OverflowError):
            raise UserError(f"{where}: '{text[:40]}' is no count; write whole numbers.") from None
    return product


def _check_amount(where: str, amount: int, what: str, most: int) -> None:
    if amount > most:
        raise UserError(
            f"{where}: up to here the scene has {amount:,} {what}, repeated ones counted each time; up to {most:,} are read. "
            "Simplify it, or leave out irrelevant parts."
        )
