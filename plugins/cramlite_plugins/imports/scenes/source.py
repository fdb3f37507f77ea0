"""Scene files as MuJoCo compiles them: includes, defaults, meshes and packages are resolved, or refused with file and line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Value
from cramlite.plugin import UserError, nearest

from .guard import Roots, check_scene

PACKAGE = re.compile(r"package://([^/\"']+)/([^\"']*)")
FILENAME = re.compile(r"(filename\s*=\s*[\"'])([^\"']+)")
READ = ("stl", "obj", "msh")
LEVEL = 0.98
"""Least share of gravity along -z (11 deg): slopes keep their tilt, and scenes with y up are refused."""
OPTIONS = {
    "timestep": (1e-5, 0.1), "iterations": (0, 10_000), "ls_iterations": (0, 10_000), "noslip_iterations": (0, 10_000),
    "ccd_iterations": (0, 10_000),
}  # fmt: skip
"""Physics options of a scene file with their permitted ranges; MuJoCo's defaults are 2 ms, 100, 50, 0 and 35."""
HEAVIEST = 100.0
"""Largest component of a scene's gravity along any axis [m/s2]: ten times the earth's, four times Jupiter's."""
PLANE = 1e6
"""Largest half length of a plane [m]: MuJoCo draws planes up to that size, and treats all as endless."""
LARGEST = 100.0
"""Largest extent of a scene [m]: a larger one must be in another unit, as the largest kitchens are 20 m long."""


class Source(Value):
    """Compiled scene file.

    Args:
        path: of the file.
        urdf: whether it is a URDF.
        spec, model, data: as MuJoCo has them; the data is that of the state the scene starts in.
        warnings: of MuJoCo, of what it left out.
    """

    path: Path
    urdf: bool
    spec: Any
    model: Any
    data: Any
    warnings: tuple[str, ...] = ()


def root_tag(path: Path) -> str:
    """Return the first tag of an XML file; empty if it has none, or cannot be read."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
    found = re.search(r"<([A-Za-z_][\w.-]*)", re.sub(r"<!--.*?-->|<\?.*?\?>", "", text, flags=re.DOTALL))
    return found[1] if found else ""


def read_source(path: Path, packages: Mapping[str, Path], keyframe: str = "", *, textures: bool = False) -> Source:
    """Compile a scene file, in the state of a keyframe if one is named.

    Args:
        textures: keep pictures on surfaces, which take longer to read than all else.

    Raises:
        UserError: XML, a mesh, an include, a package, a mass or a number cannot be used; with file and line.
    """
    urdf = root_tag(path) == "robot"
    check_scene(path, path.read_text(encoding="utf-8", errors="replace"), packages.values())
    try:
        with _warnings() as warned:
            spec = mujoco.MjSpec.from_string(_urdf(path, packages)) if urdf else mujoco.MjSpec.from_file(str(path))
            if urdf:
                _loosen(spec)
            if not textures:
                _drop_textures(spec)
            model = spec.compile()
    except (ValueError, RuntimeError, MemoryError) as error:  # RuntimeError: of C++, such as that no memory is left
        raise UserError(_explained(path, str(error))) from error
    _check_options(path, model)
    data = mujoco.MjData(model)
    _start(path, model, data, keyframe)
    mujoco.mj_forward(model, data)
    _check_numbers(path, model, data)
    _check_shapes(path, model, data)
    _check_up(path, model)
    return Source(path, urdf, spec, model, data, tuple(dict.fromkeys(warned)))


@contextmanager
def _warnings() -> Iterator[list[str]]:
    """Collect the warnings of MuJoCo, which it would print and append to MUJOCO_LOG.TXT in the user's
    folder."""
    said, before = list[str](), mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    try:
        yield said
    finally:
        mujoco.set_mju_user_warning(before)


def _drop_textures(spec: Any) -> None:
    """Leave out the textures of a scene, which take longer to read than all else; the colours of materials stay."""
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for texture in list(spec.textures):
        spec.delete(texture)


def _loosen(spec: Any) -> None:
    """Move the floating links of a URDF to the top level of the model, since MuJoCo takes free joints only there.

    Their poses in the world stay.
    """
    spec.compiler.fusestatic = False
    loose = [b for b in spec.bodies for j in b.joints if int(j.type) == 0 and b.parent.name != "world"]
    for body in loose:
        for joint in list(body.joints):
            spec.delete(joint)
    if not loose:
        return
    model = spec.copy().compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    spec.copy_during_attach = True
    for body in loose:
        name, there = body.name, data.body(body.name)
        frame = spec.worldbody.add_frame(pos=there.xpos, quat=there.xquat)
        body.pos, body.quat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
        moved = frame.attach_body(body, "moved/", "")
        spec.delete(body)
        moved.name = name
        moved.add_freejoint()


def _start(path: Path, model: Any, data: Any, keyframe: str) -> None:
    names = [model.key(k).name for k in range(model.nkey)]
    if keyframe and keyframe not in names:
        raise UserError(f"{path}:1: there is no keyframe '{keyframe}'; {nearest(keyframe, names)}.")
    if keyframe:
        mujoco.mj_resetDataKeyframe(model, data, names.index(keyframe))


def _check_numbers(path: Path, model: Any, data: Any) -> None:
    for b in range(1, model.nbody):
        name = model.body(b).name
        if not np.isfinite([*data.xpos[b], model.body_mass[b], *model.body_inertia[b]]).all():
            raise UserError(f"{path}:{_line(path, name)}: body '{name}' has a pose, mass or inertia that is no finite number.")
        if np.abs(data.xpos[b]).max() > LARGEST:
            far = float(np.abs(data.xpos[b]).max())
            raise UserError(
                f"{path}:{_line(path, name)}: body '{name}' is {far:.6g} m away; scenes are in metres and reach {LARGEST:g} m. "
                "If this one is in millimetres, scale it by 0.001."
            )


def _check_shapes(path: Path, model: Any, data: Any) -> None:
    """Refuse a scene with a shape whose size or pose is not finite, or which is larger than ``LARGEST``
    (``PLANE`` for a plane)."""
    for g in range(model.ngeom):
        plane = model.geom_type[g] == mujoco.mjtGeom.mjGEOM_PLANE
        reach, most = (model.geom_size[g][:2].max(), PLANE) if plane else (model.geom_rbound[g], LARGEST)
        if not (np.isfinite([*data.geom_xpos[g], *data.geom_xmat[g]]).all() and reach <= most):
            what, body = model.geom(g).name, model.body(model.geom_bodyid[g]).name
            size = f"reaches {float(reach):.6g} m" if np.isfinite(reach) else "is of no finite size"
            raise UserError(
                f"{path}:{_line(path, what or body)}: the shape {f'{what!r} ' if what else ''}of body '{body}' {size}; up to {most:g} m is "
                "taken. If it is in millimetres, scale it by 0.001."
            )


def _check_options(path: Path, model: Any) -> None:
    """Refuse a scene whose time step or number of solver iterations is out of range: steps might never end, or move nothing."""
    for name, (least, most) in OPTIONS.items():
        value = float(getattr(model.opt, name))
        if not least <= value <= most:
            raise UserError(f"{path}:{_line(path, f'{value:g}')}: the option {name} is {value:g}; it must be from {least:g} to {most:g}.")


def _check_up(path: Path, model: Any) -> None:
    """Refuse a scene whose gravity is not along -z, since its things would stand on their sides."""
    down = np.array(model.opt.gravity)
    if not np.abs(down).max() <= HEAVIEST:
        said = ", ".join(f"{v:g}" for v in down)
        raise UserError(f"{path}:{_line(path, 'gravity')}: gravity is ({said}) m/s2; it must be at most {HEAVIEST:g} m/s2 along each axis.")
    if np.linalg.norm(down) > 1.0 and -down[2] < LEVEL * np.linalg.norm(down):
        said = ", ".join(f"{v:g}" for v in down)
        raise UserError(
            f"{path}:{_line(path, 'gravity')}: gravity is ({said}), and scenes here have z upwards; turn it, such as with "
            "<frame euler=\"90 0 0\"> around all of its bodies where y is up."
        )


def _urdf(path: Path, packages: Mapping[str, Path]) -> str:
    """Return the text of a URDF, with paths of files that MuJoCo finds; refuse a URDF with more than one root link.

    MuJoCo would drop the other roots without a word.
    """
    text = path.read_text(encoding="utf-8", errors="replace")
    bare = re.sub(r"<!--.*?-->", lambda c: "\n" * c[0].count("\n"), text, flags=re.DOTALL)
    if made := re.search(r"<xacro:|\$[{(]", bare):
        line = bare.count("\n", 0, made.start()) + 1
        raise UserError(f"{path}:{line}: this is xacro, from which a URDF is made: 'xacro {path.name} > scene.urdf', and read that.")
    text = _without_pictures(path, text, packages)
    lines = [_resolved(path, k, line, packages) for k, line in enumerate(text.splitlines(), 1)]
    joined = "\n".join(lines)
    links = re.findall(r"<link\b[^>]*\bname\s*=\s*[\"']([^\"']+)", joined)
    roots = [name for name in links if not re.search(rf"<child\b[^>]*[\"']{re.escape(name)}[\"']", joined)]
    if len(roots) > 1:
        raise UserError(
            f"{path}:{_line(path, roots[1])}: a URDF has one root link, this one has {len(roots)}: {', '.join(roots[:4])}; "
            "join them by fixed joints to a link 'world'."
        )
    if re.search(r"<mujoco\b", joined):
        return joined
    compiler = '<mujoco><compiler fusestatic="false" strippath="false" discardvisual="false"/></mujoco>'
    return re.sub(r"(<robot\b[^>]*>)", rf"\1{compiler}", joined, count=1)


def _without_pictures(path: Path, text: str, packages: Mapping[str, Path]) -> str:
    """The scene file's text without visuals whose mesh is missing or not readable; most such meshes are in
    formats for renderers."""

    def kept(found: re.Match[str]) -> str:
        try:
            for k, line in enumerate(found[0].splitlines()):
                _resolved(path, k, line, packages)
        except UserError:
            return "\n" * found[0].count("\n")
        return found[0]

    return re.sub(r"<visual\b[^>]*>.*?</visual>", kept, text, flags=re.DOTALL)


def _resolved(path: Path, line: int, text: str, packages: Mapping[str, Path]) -> str:
    def file(found: re.Match[str]) -> str:
        package = PACKAGE.fullmatch(found[2])
        where = f"{path}:{line}"
        target = _package(path, where, package[1], packages) / package[2] if package else path.parent / found[2].removeprefix("file://")
        if not target.is_file():
            raise UserError(f"{where}: there is no file '{target}', to which '{found[2]}' refers.")
        Roots(path, (*packages.values(), *([_package(path, where, package[1], packages)] if package else []))).check(where, target)
        if target.suffix[1:].lower() not in READ:
            raise UserError(f"{where}: '{target.name}' is no mesh that MuJoCo reads ({', '.join(READ)}); convert it.")
        return f"{found[1]}{target.resolve()}"

    return FILENAME.sub(file, text) if "<mesh" in text or FILENAME.search(text) else text


def _package(path: Path, where: str, name: str, packages: Mapping[str, Path]) -> Path:
    """Folder of a package: the stated one, else the nearest of its name among the file's parents and their
    subfolders."""
    if name in packages:
        return packages[name]
    for folder in path.resolve().parents:
        if folder.name == name:
            return folder
        if (folder / name).is_dir():
            return folder / name
    raise UserError(
        f"{where}: the package '{name}' is in no folder above the file; say where it is: 'packages: {{{name}: FOLDER}}' beside 'file' "
        f"in a scenario, or 'cramlite import' with --package {name}=FOLDER."
    )


def _explained(path: Path, error: str) -> str:
    """MuJoCo's reason for refusing a model, in one line, after the file and, as far as it is known, the
    line."""
    reason = " ".join(error.split())
    stated = re.search(r"[Ll]ine(?: number=|\s)(\d+)", reason)
    names = re.findall(r"'([^']+)'", reason)
    for file in _files(path):
        for name in names:
            line = _line(file, Path(name).name, 0)
            if line:
                return f"{file}:{line}: {_said(reason)}"
    return f"{path}:{stated[1] if stated else 1}: {_said(reason)}"


def _said(reason: str) -> str:
    reason = re.sub(r"^(XML )?Error: |Error=|ErrorID=\S+ \S+ ", "", reason)
    hints = {
        "Error opening file": "put the file there, or correct its name or 'meshdir'",
        "mass and inertia of moving bodies": "give the body a mass, or a geom with one",
        "number of faces": "simplify the mesh to some 20,000 faces; an STL in ASCII must be saved in binary, or as OBJ",
        "already included": "a file includes itself; take one 'include' out",
        "XML": "correct the XML",
    }
    hint = next((h for key, h in hints.items() if key in reason), "correct what is named there")
    return f"MuJoCo does not take the scene: {reason}; {hint}."


def _files(path: Path, seen: tuple[Path, ...] = ()) -> list[Path]:
    """Return a scene file and all files that it includes, each once."""
    if not path.is_file() or path in seen:
        return []
    found = [path]
    for name in re.findall(r"<include\b[^>]*file\s*=\s*[\"']([^\"']+)", path.read_text(encoding="utf-8", errors="replace")):
        found += [f for f in _files(path.parent / name, (*seen, *found)) if f not in found]
    return found


def _line(path: Path, word: str, otherwise: int = 1) -> int:
    """Return the number of the first line of a file in which a name is in quotes, alone or at the end of a path."""
    if not word:
        return otherwise
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    shape = re.compile(rf"[\"'/]{re.escape(word)}[\"']")
    return next((k for k, line in enumerate(lines, 1) if shape.search(line)), otherwise)
