# ruff: noqa: E501 (texts that would mean something else in two lines)
"""Files of somebody who means harm, each with the words that its refusal says: scenes, views, YAML and ontologies."""

from __future__ import annotations

import json
import os
import struct
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path

BOX = '<body name="b"><freejoint/><geom type="box" size=".1 .1 .1"/></body>'
CAMERA = json.dumps({"fx": 500, "fy": 500, "cx": 320, "cy": 240, "width": 640, "height": 480})
RDF = 'xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"'
SECRET = "../secret.txt"
"""Path of a file beside the folder of the hostile files, which a scene must not read."""


def _mjcf(rest: str = "", body: str = BOX) -> str:
    return f"<mujoco>{rest}<worldbody>{body}</worldbody></mujoco>"


def _mesh(file: str) -> str:
    return _mjcf(f'<asset><mesh name="m" file="{file}"/></asset>', '<body name="b"><geom type="mesh" mesh="m"/></body>')


def _urdf(inner: str) -> str:
    return f'<robot name="r"><link name="a">{inner}</link></robot>'


BOMB = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10 if k else "ha"}">' for k in range(10))
SCENES: Mapping[str, tuple[str, str]] = {
    "include outside": (_mjcf(f'<include file="{SECRET}"/>'), "outside of the scene's folder"),
    "include of a device": (_mjcf('<include file="/dev/zero"/>'), "outside of the scene's folder"),
    "mesh outside": (_mesh("../secret.stl"), "outside of the scene's folder"),
    "mesh by an absolute path": (_mesh("/dev/zero"), "outside of the scene's folder"),
    "mesh in a folder outside": (_mesh("secret.stl").replace("<asset>", '<compiler meshdir=".."/><asset>'), "outside of the scene's folder"),
    "path written with entities": (_mjcf('<include file="&#46;&#46;/secret.txt"/>'), "outside of the scene's folder"),
    "through a folder that is not there": (_mjcf('<include file="none/../../secret.txt"/>'), "outside of the scene's folder"),
    "backslashes": (_mjcf('<include file="..\\secret.txt"/>'), "outside of the scene's folder"),
    "folder with backslashes": (_mesh("secret.stl").replace("<asset>", '<compiler meshdir="none\\..\\.."/><asset>'), "outside of the scene's folder"),
    "like an address": (_mjcf('<include file="/none://../etc/passwd"/>'), "outside of the scene's folder"),
    "folder of meshes from an included file": (_mesh("secret.stl").replace("</mujoco>", '<include file="part.xml"/></mujoco>'), "outside of the scene's folder"),
    "archive": (_mjcf('<asset><model name="x" file="part.mjz"/></asset>'), "is no XML"),
    "link to outside": (_mesh("link.stl"), "outside of the scene's folder"),
    "pipe": (_mesh("pipe.stl"), "a device or a pipe"),
    "mesh that lies": (_mesh("lie.stl"), "number of faces"),
    "attached to itself": (_mjcf('<asset><model name="x" file="scene.xml"/></asset>', '<body name="q"><attach model="x" body="q" prefix="p"/></body>'), "includes itself"),
    "entities": (f"<!DOCTYPE m [{BOMB}]>{_mjcf('', BOX.replace('b', '&e9;', 1))}", "entity 'e1' is nested"),
    "external entity": (f'<!DOCTYPE m [<!ENTITY x SYSTEM "file:///etc/passwd">]>{_mjcf()}', "entity 'x' is nested, external"),
    "deep": (_mjcf("", "<body>" * 20_000 + "</body>" * 20_000), "nested more than 500 deep"),
    "hidden in an attribute": ('<mujoco model="<!--"><include file="../secret.txt"/><custom model="-->"/></mujoco>', "not XML"),
    "replicate": (_mjcf("", f'<replicate count="100000000">{BOX}</replicate>'), "elements, repeated"),
    "replicate in replicate": (_mjcf("", '<replicate count="300">' * 3 + BOX + "</replicate>" * 3), "repeated ones"),
    "flex": (_mjcf("", '<flexcomp name="f" type="grid" count="2000 2000 2000" dim="3"/>'), "elements, repeated"),
    "height field": (_mjcf('<asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>'), "cells (nrow x ncol)"),
    "texture": (_mjcf('<asset><texture name="t" builtin="flat" width="200000" height="200000"/></asset>'), "cells (width x height)"),
    "many textures": (_mjcf('<asset>' + '<texture builtin="flat" width="4096" height="4096"/>' * 2 + '</asset>'), "cells (width x height)"),
    "made mesh": (_mjcf('<asset><mesh name="m" builtin="supersphere" params="100000 1 1"/></asset>'), "points of a mesh"),
    "sensor": (_mjcf("", BOX).replace("</mujoco>", '<sensor><user dim="2000000000"/></sensor></mujoco>'), "cells (dim)"),
    "sizes": (_mjcf('<size nkey="2000000000"/>'), "sizes x elements"),
    "memory": (_mjcf('<size memory="900P"/>'), "scene.xml:1: "),
    "bodies": (_mjcf("", "<body><freejoint/><geom size='.1'/></body>" * 2_001), "2,001 bodies"),
    "huge number": (_mjcf("", BOX.replace(".1 .1 .1", "1e400 1 1")), "number is too large"),
    "far away": (_mjcf("", BOX.replace("<body", '<body pos="1e308 1e308 0"')), "m away; scenes are in metres"),
    "step without end": (_mjcf('<option timestep="1e-300"/>'), "the option timestep is 1e-300"),
    "iterations without end": (_mjcf('<option noslip_iterations="2000000000"/>'), "the option noslip_iterations"),
    "zeros": ("<mujoco>\0\0</mujoco>", "not XML"),
    "urdf, mesh outside": (_urdf('<collision><geometry><mesh filename="../secret.stl"/></geometry></collision>'), "outside of the scene's folder"),
    "urdf, out of a package": (_urdf('<collision><geometry><mesh filename="package://meshes/../../secret.stl"/></geometry></collision>'), "outside of the scene's folder"),
    "urdf, include": (_urdf(f'<include file="{SECRET}"/>'), "outside of the scene's folder"),
    "urdf, entities": (f"<!DOCTYPE m [{BOMB}]>{_urdf('')}", "entity 'e1'"),
}  # fmt: skip


def around_scene(folder: Path) -> None:
    """Write the files that the hostile scenes name: a pipe, a link, a mesh that claims four billion faces; and files that must not be
    read."""
    (folder.parent / "secret.txt").write_text("SECRET")
    (folder.parent / "secret.stl").write_bytes(bytes(84))
    (folder / "meshes").mkdir()
    (folder / "lie.stl").write_bytes(b" " * 80 + (4_000_000_000).to_bytes(4, "little") + bytes(50))
    (folder / "link.stl").symlink_to(folder.parent / "secret.stl")
    (folder / "part.xml").write_text('<mujoco><compiler meshdir=".."/></mujoco>')
    with zipfile.ZipFile(folder / "part.mjz", "w") as archive:
        archive.writestr("part.xml", "<mujoco><worldbody><body name='hidden'><geom size='.1'/></body></worldbody></mujoco>")
    os.mkfifo(folder / "pipe.stl")


def _repeated(kind: str) -> str:
    lines = ["a: &a {x: 1}" if kind == "<<" else "a: &a [x, x]"]
    for one, other in zip("abcdefghi", "bcdefghij", strict=True):
        all_ = ", ".join([f"*{one}"] * 9)
        lines.append(f"{other}: &{other} {{<<: [{all_}]}}" if kind == "<<" else f"{other}: &{other} [{all_}]")
    return "\n".join(lines)


YAML: Mapping[str, tuple[str, str]] = {
    "aliases": (_repeated("[]"), "more than 1000000 values"),
    "merged aliases": (_repeated("<<"), "more than 1000000 values"),
    "alias in itself": ("a: &a [*a]", "recursive"),
    "deep": ("a: " + "[" * 500 + "]" * 500, "nested more than 100 deep"),
    "deep by aliases": ("".join(f"k{k}: &k{k} [{f'*k{k - 1}' if k else 'x'}]\n" for k in range(150)), "nested more than 100 deep"),
    "object": ('a: !!python/object/apply:os.system ["true"]', "not allowed"),
    "number": ("a: " + "9" * 5000, "not valid YAML"),
    "codes of terminals": ('scenario: "\\e[2J"', "'\\x1b[2J' is no name"),
    "twice": ("a: 1\na: 2", "duplicate key"),
}

ONTOLOGIES: Mapping[str, tuple[str, str, str]] = {
    "context of an address": ("x.jsonld", '{"@context": "http://127.0.0.1:9/x", "@id": "http://x#a"}', "in another file or at an address"),
    "context of a file": ("x.jsonld", '{"@context": [{}, "file:///etc/passwd"], "@id": "http://x#a"}', "in another file or at an address (file:"),
    "entities": ("x.owl", f"<!DOCTYPE r [{BOMB}]><rdf:RDF {RDF}>&e9;</rdf:RDF>", "entity 'e1'"),
    "external entity": ("x.owl", f'<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><rdf:RDF {RDF}>&x;</rdf:RDF>', "entity 'x'"),
    "deep XML": ("x.owl", f"<rdf:RDF {RDF}>{'<a>' * 20_000}{'</a>' * 20_000}</rdf:RDF>", "nested more than 500"),
    "deep brackets": ("x.ofn", f"Prefix(:=<http://x#>)\nOntology(<http://x> SubClassOf(:A {'ObjectComplementOf(' * 100_000}:B", "nested more than 100"),
    "deep Turtle": ("x.ttl", f"@prefix : <http://x#> .\n:a :b {'[ :b ' * 50_000}1 {']' * 50_000} .", "recursion"),
}
"""Hostile ontologies: file name, text, and words of the refusal."""
IMPORTS: Mapping[str, tuple[str, str]] = {
    "RDF/XML": ("x.owl", f'<rdf:RDF {RDF} xmlns:owl="http://www.w3.org/2002/07/owl#"><owl:Ontology rdf:about="http://x">'
                '<owl:imports rdf:resource="http://127.0.0.1:9/x.owl"/><owl:imports rdf:resource="file:///etc/passwd"/></owl:Ontology></rdf:RDF>'),
    "functional": ("x.ofn", "Prefix(:=<http://x#>)\nOntology(<http://x> Import(<http://127.0.0.1:9/x.owl>) Import(<file:///etc/passwd>))"),
    "Turtle": ("x.ttl", "<http://x> <http://www.w3.org/2002/07/owl#imports> <http://127.0.0.1:9/x.owl>, <file:///etc/passwd> ."),
}  # fmt: skip
"""Ontologies with imports of addresses and files that must not be opened."""


def _png(folder: Path, width: int, height: int) -> Path:
    def part(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = part(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0))
    (folder / "depth.png").write_bytes(b"\x89PNG\r\n\x1a\n" + head + part(b"IDAT", zlib.compress(b"")) + part(b"IEND", b""))
    (folder / "intrinsics.json").write_text(CAMERA)
    return folder


def _zipped(folder: Path, name: str, content: bytes) -> Path:
    with zipfile.ZipFile(folder / "view.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)
    return folder / "view.npz"


def _saying(path: Path, size: int) -> Path:
    """Falsify the directory of a ZIP archive, so that it states a wrong unpacked size of its file."""
    content = bytearray(path.read_bytes())
    at = content.index(b"PK\x01\x02") + 24
    content[at : at + 4] = struct.pack("<I", size)
    path.write_bytes(content)
    return path


def npy(shape: tuple[int, ...], kind: str, data: bytes) -> bytes:
    """Return the bytes of a NumPy file (format 1.0) with any header."""
    header = f"{{'descr': {kind!r}, 'fortran_order': False, 'shape': {shape!r}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + data


def _cloud(folder: Path, name: str, text: str) -> Path:
    (folder / name).with_suffix(".json").write_text(CAMERA)
    (folder / name).write_text(text)
    return folder / name


PLY = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
PCD = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1000000000\nPOINTS 20000000\nDATA ascii\n1 2 3\n"
CODE = b"cos\nsystem\n(S'touch pwned'\ntR."
VIEWS: Mapping[str, tuple[Callable[[Path], Path], str]] = {
    "image of ten billion pixels": (lambda f: _png(f, 100_000, 100_000), "depth.png"),
    "image of 144 million pixels": (lambda f: _png(f, 12_000, 12_000), "depth.png"),
    "archive that unpacks to 600 MB": (lambda f: _saying(_zipped(f, "depth.npy", bytes(100)), 600_000_000), "0.6 GB, and 0.5 GB are allowed"),
    "array of 8 TB": (lambda f: _zipped(f, "depth.npy", npy((10**6, 10**6), "<f8", b"")), "by its header, but only"),
    "negative shape": (lambda f: _zipped(f, "depth.npy", npy((-1,), "<f8", b"")), "no NumPy archive"),
    "pickle": (lambda f: _zipped(f, "depth.npy", npy((1,), "|O", CODE)), "pickles"),
    "name outside": (lambda f: _zipped(f, "../../depth.npy", npy((0,), "<f8", b"")), "no array 'depth'"),
    "cloud of four billion points": (lambda f: _cloud(f, "c.ply", PLY), "cannot be read as PLY"),
    "cloud of large fields": (lambda f: _cloud(f, "c.pcd", PCD), "PCD header"),
}
