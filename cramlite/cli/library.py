"""``cramlite library``: builds a library of object models from mesh and MJCF files, and lists what it made."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import UserError
from .arguments import Add, plugin_choice
from .texts import counted, warn_of

if TYPE_CHECKING:
    from ..model.world.known_kind import BuiltLibrary, KnownKind

DENSITY = 500.0
"""Density of kinds whose files state no mass [kg/m3]: full cartons have 300 to 800."""


def add_commands(add: Add) -> None:
    """Add the command ``library``, with its arguments, to the command line."""
    library = add("library", _library)
    library.add_argument("action", choices=["add"], help="add the kinds of a folder to a library")
    library.add_argument("folders", nargs="+", type=Path, metavar="FOLDER", help="with OBJ, GLB, PLY, STL or MJCF files, also below")
    library.add_argument("--out", type=Path, default=Path("library"), metavar="LIB", help="folder of the library (default: library)")
    library.add_argument("--scale", type=float, default=1.0, help="from the unit of mesh files to metres, e.g. 0.001 (default 1)")
    library.add_argument(
        "--density", type=float, default=DENSITY,
        help=f"density of object models whose files state no mass [kg/m3], default {DENSITY:g}",
    )  # fmt: skip
    library.add_argument(
        "--up", choices=["x", "y", "z", "down-x", "down-y", "down-z"], default="",
        help="axis of the kinds' frames that usually points up, or down; by default their shapes tell",
    )  # fmt: skip


def _library(arguments: argparse.Namespace) -> int:
    registry = plugin_choice(arguments).registry()
    up = str(arguments.up).replace("down-", "-")
    if not (1e-6 <= arguments.scale <= 1e6 and 1.0 <= arguments.density <= 30_000.0):
        raise UserError(
            f"--scale {arguments.scale:g} --density {arguments.density:g}: a scale lies between 1e-6 and 1e6, a density between 1 "
            "and 30000 kg/m3 (cartons 300 to 800, water 1000, steel 7850)."
        )
    kinds = 0
    for folder in arguments.folders:
        if not folder.is_dir():
            raise UserError(f"There is no folder '{folder}'; name one with OBJ, GLB, PLY, STL or MJCF files.")
        built: BuiltLibrary | None = registry.first(
            "add_models", folder=folder, library=arguments.out, scale=arguments.scale, density=arguments.density, up=up
        )
        warn_of(registry.faults)
        if built is None:
            raise UserError(f"No plugin can make a library from '{folder}'; see 'cramlite plugins'.")
        print("\n".join(_lines(built)))
        kinds += len(built.kinds)
    if not kinds:
        searched = ", ".join(map(str, arguments.folders))
        raise UserError(f"No file in {searched} could be read as a kind of object: OBJ, GLB, PLY, STL, OFF and MJCF files are read.")
    print(f"{counted(kinds, 'kind')} in {arguments.out}; use them in a scenario by 'models: [{arguments.out}]'.")
    return 0


def _lines(built: BuiltLibrary) -> list[str]:
    lines = [line for kind in built.kinds for line in _kind(kind)]
    if built.refused:
        said = "; ".join(f"'{file}': {why.rstrip('.')}" for file, why in built.refused.items())
        lines.append(f"Refused, {counted(len(built.refused), 'file')}: {said}.")
    if built.parts:
        lines.append(f"{counted(built.parts, 'more file')} {'was' if built.parts == 1 else 'were'} read as a part of one of these objects.")
    return lines


def _kind(kind: KnownKind) -> list[str]:
    size = " x ".join(f"{1000 * v:.0f}" for v in kind.extents)
    texture = f"texture {kind.texture[0]} x {kind.texture[1]}" if kind.texture else "no texture, plain colours"
    weight = kind.mass_source if kind.mass is not None else f"fixed (with joints; {kind.mass_source})"
    head = f"{kind.name}{' (unchanged)' if kind.kept else ''}: {size} mm, {kind.triangles:,} triangles, {texture}"
    lines = [head, f"  mass {weight}; up {kind.up}"]
    if kind.joints:
        lines.append(f"  joints: {', '.join(kind.joints)}; recognised at any of their values")
    called = [", ".join(words) for words in (kind.looks.nouns, kind.looks.colours) if words]
    if called:
        marks = f", with {', '.join(kind.looks.marks)} on it" if kind.looks.marks else ""
        lines.append(f"  sentences may call it: {'; '.join(called)}{marks}")
    return [*lines, *(f"  {note}" for note in kind.notes)]
