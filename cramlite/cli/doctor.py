"""``cramlite doctor``: checks whether this machine has the parts that cramlite needs, in ten lines."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from importlib import metadata
from typing import TYPE_CHECKING

from ..base.value import Value
from .arguments import Add, plugin_choice

if TYPE_CHECKING:
    from packaging.requirements import Requirement

    from ..plugin.selection import PluginChoice

OURS = "cramlite"
STYLES = {"ok": "green", "without": "yellow", "lacks": "bold red"}


class Examined(Value):
    """Line that ``cramlite doctor`` prints: one check of the machine, and its result.

    Args:
        what: what was looked at.
        state: "ok"; "without" what only some commands need; "lacks" what everything needs.
        found: what there is, and what to do about what there is not.
    """

    what: str
    state: str
    found: str


def examine(plugins: PluginChoice) -> list[Examined]:
    """Check this machine, quick checks first; importing the libraries takes a few seconds."""
    from ..version import VERSION

    return [
        Examined(OURS, "ok", f"{VERSION} on {_system()}"),
        python(),
        libraries(_requirements("")),
        extras(),
        cores(),
        memory(),
        graphics(),
        fonts(),
        folders(),
        _plugins(plugins),
    ]


def _system() -> str:
    import platform

    return f"{platform.system()} {platform.machine()}"


def python() -> Examined:
    """Compare the version of Python with those that are supported."""
    from packaging.specifiers import SpecifierSet

    wanted = metadata.metadata(OURS)["Requires-Python"]
    version = ".".join(map(str, sys.version_info[:3]))
    if SpecifierSet(wanted).contains(version):
        return Examined("Python", "ok", version)
    return Examined("Python", "lacks", f"{version}, and {wanted} is needed: make the environment anew with such a Python")


def libraries(wanted: Iterable[Requirement]) -> Examined:
    """Check that the required libraries are installed, have a supported version, and can be used."""
    needed = list(wanted)
    wrong = [said for r in needed if (said := _wrong(r) or _unusable(r.name))]
    if wrong:
        return Examined("libraries", "lacks", f"{'; '.join(wrong)}. Install {OURS} anew: pip install {OURS}")
    return Examined("libraries", "ok", f"all {len(needed)} required libraries are installed, in supported versions, and can be used")


def extras() -> Examined:
    """List the optional parts of cramlite that are installed completely, and those that are not; import
    none of them."""
    names = [n for n in metadata.metadata(OURS).get_all("Provides-Extra") or () if n not in ("docs", "test")]
    lacking = {name: [said for r in _requirements(name) if (said := _wrong(r))] for name in names}
    there = ", ".join(name for name in names if not lacking[name]) or "none"
    away = "; ".join(f"{name} ({', '.join(why)})" for name, why in lacking.items() if why)
    if not away:
        return Examined("extras", "ok", there)
    return Examined("extras", "without", f"{there}; not {away}: pip install '{OURS}[NAME]'")


def cores() -> Examined:
    """Count the processor's cores that this process may use, and how busy they are."""
    import os

    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return Examined("cores", "ok", f"{usable} of {os.cpu_count()} may be used{load}")


def memory() -> Examined:
    """Measure the memory of the machine."""
    import os

    try:
        pages, size = os.sysconf("SC_PHYS_PAGES"), os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return Examined("memory", "without", "unknown: this system does not say")
    return Examined("memory", "ok", f"{pages * size / 2**30:.1f} GiB")


def graphics() -> Examined:
    """Check for the OpenGL libraries, which only the optional package open3d needs."""
    from ctypes.util import find_library

    away = [f"lib{name}" for name in ("GL", "EGL") if not find_library(name)]
    if not away:
        return Examined("OpenGL", "ok", "libGL and libEGL are there; only the extra open3d needs them")
    return Examined("OpenGL", "without", f"no {' and no '.join(away)}: cramlite's pictures do not need it, the extra open3d does")


def fonts() -> Examined:
    """Check that Pillow was built with FreeType, so that it can draw text with its own font."""
    from PIL import features

    if features.check("freetype2"):
        return Examined("fonts", "ok", f"Pillow's own, with FreeType {features.version('freetype2')}")
    return Examined("fonts", "without", "this Pillow has no FreeType: writing in pictures is coarse; pip install --force-reinstall pillow")


def folders() -> Examined:
    """Check that the working folder, where runs go, and the folder of cached results can be written."""
    import os
    from pathlib import Path

    from ..base.cache import cache_folder

    cache = cache_folder()
    nearest = next((p for p in (cache, *cache.parents) if p.exists()), Path("/"))
    wrong = [str(p) for p in (nearest, Path.cwd()) if not os.access(p, os.W_OK)]
    if wrong:
        return Examined("folders", "without", f"nothing can be written in {' and '.join(wrong)}: --out says where runs go")
    return Examined("folders", "ok", f"runs can be written in {Path.cwd()}, cached results in {cache}")


def _plugins(plugins: PluginChoice) -> Examined:
    """Load every plugin that is chosen."""
    from ..plugin.catalogue import examine

    registry = plugins.registry(strict=False)
    examine(registry)
    faults = list(dict.fromkeys(map(str, registry.faults)))
    if faults:
        return Examined("plugins", "lacks", f"{len(faults)} fault{'s' if len(faults) > 1 else ''}: {'; '.join(faults)}")
    return Examined("plugins", "ok", f"all {len(registry.infos)} can be used")


def _requirements(extra: str) -> list[Requirement]:
    """Return the Python packages that cramlite always requires or, given the name of a pip extra, those of
    the extra."""
    from packaging.requirements import Requirement

    found = [Requirement(text) for text in metadata.requires(OURS) or ()]
    optional = [r for r in found if r.marker is not None and "extra" in str(r.marker)]
    chosen = optional if extra else [r for r in found if r not in optional]
    return [r for r in chosen if r.marker is None or r.marker.evaluate({"extra": extra})]


def _wrong(wanted: Requirement) -> str:
    """Defect of an installed library; "" if it has none."""
    try:
        version = metadata.version(wanted.name)
    except metadata.PackageNotFoundError:
        return f"{wanted.name} is not installed"
    return "" if wanted.specifier.contains(version, prereleases=True) else f"{wanted.name} {version} is not {wanted.specifier}"


def _unusable(name: str) -> str:
    """Why a library cannot be used; "" if it can.

    The planner of goals is a program of its own: it is run on a small problem, and its package is never
    imported.
    """
    from ..planning.symbolic.symbolic_planner import PACKAGE

    return _not_running(name) if name == PACKAGE else _not_importable(name)


def _not_running(planner: str) -> str:
    """Try the PDDL planner on a problem of one action; return why it cannot be run, or "" if it can."""
    from ..base.errors import CramliteError
    from ..planning.symbolic.symbolic_planner import examine_planner

    try:
        examine_planner()
    except (CramliteError, OSError) as error:
        return f"{planner} cannot be run: {error}"
    return ""


def _not_importable(name: str) -> str:
    """Why a library cannot be imported, such as a missing library of the system; "" if it can."""
    import importlib
    import warnings

    files = metadata.files(name) or ()
    tops = {f.parts[0] for f in files if len(f.parts) == 2 and f.name == "__init__.py"} or {name.replace("-", "_")}
    try:
        with warnings.catch_warnings(action="ignore"):
            for top in sorted(tops):
                importlib.import_module(top)
    except Exception as error:
        return f"{name} cannot be imported: {str(error).strip().splitlines()[0]}"
    return ""


def _doctor(arguments: argparse.Namespace) -> int:
    from ..base.json_text import as_json

    examined = examine(plugin_choice(arguments))
    if arguments.json:
        print(as_json(examined))
    else:
        _show(examined)
    return int(any(e.state == "lacks" for e in examined))


def _show(examined: list[Examined]) -> None:
    """Print one line for each check of the machine, in colours where the terminal has them."""
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False)
    for e in examined:
        console.print(Text.assemble((f"{e.state:<8}", STYLES[e.state]), (f"{e.what:<11}", "bold"), e.found), soft_wrap=True)


def add_commands(add: Add) -> None:
    """Add the command ``doctor``, with its arguments, to the command line."""
    doctor = add("doctor", _doctor)
    doctor.add_argument("--json", action="store_true", help="print as JSON: what, state and found of each line")
