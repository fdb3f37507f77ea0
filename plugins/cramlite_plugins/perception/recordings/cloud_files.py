"""Point cloud files: PLY by trimesh, PCD by a small reader of its ascii and binary forms.

PCD: https://pointclouds.org/documentation/tutorials/pcd_file_format.html, version .7.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cramlite.model import Points, Value
from cramlite.plugin import UserError

MOST = 20_000_000
"""Points: ten frames of the largest depth camera; more is a map, not a view."""
TYPES = {("F", 4): "<f4", ("F", 8): "<f8", ("U", 1): "u1", ("U", 2): "<u2", ("U", 4): "<u4",
         ("I", 1): "i1", ("I", 2): "<i2", ("I", 4): "<i4"}  # fmt: skip


class Cloud(Value, eq=False):
    """Point cloud (N, 3) [m], all finite, with colours (N, 3) uint8 where the file has them."""

    points: Points
    colours: NDArray[np.uint8] | None = None


def read_cloud(path: Path) -> Cloud:
    """Read a point cloud; points that are not finite, which organised clouds have, are left out.

    Raises:
        UserError: it cannot be read, has no points, or none that is finite.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: cannot be read: {error.strerror}.") from error
    points, colours = (_ply if path.suffix.lower() == ".ply" else _pcd)(data, path)
    if len(points) == 0:
        raise UserError(f"{path}: the cloud is empty.")
    finite = np.isfinite(points).all(1)
    if not finite.any():
        raise UserError(
            f"{path}: none of the {len(points)} points is finite; nothing was measured, or it was saved wrongly."
        )
    return Cloud(points[finite].astype(float), None if colours is None else colours[finite].astype(np.uint8))


def _ply(data: bytes, path: Path) -> tuple[Any, Any]:
    import trimesh

    try:
        loaded = trimesh.load(io.BytesIO(data), file_type="ply", process=False)
        points = np.asarray(loaded.vertices, dtype=float).reshape(-1, 3)
    except Exception as error:  # trimesh's readers raise whatever their parsers do
        raise UserError(f"{path}: cannot be read as PLY ({type(error).__name__}: {str(error)[:100]}).") from error
    colours = getattr(getattr(loaded, "visual", None), "vertex_colors", getattr(loaded, "colors", None))
    colours = None if colours is None else np.asarray(colours)
    return points, colours[:, :3] if colours is not None and colours.shape[:1] == points.shape[:1] else None


def _pcd(data: bytes, path: Path) -> tuple[Any, Any]:
    header, body = _pcd_header(data, path)
    try:
        names, count = header["FIELDS"], int(header["POINTS"][0])
        kinds = [TYPES[t, int(s)] for t, s in zip(header["TYPE"], header["SIZE"], strict=True)]
        repeats = [int(c) for c in header.get("COUNT", ["1"] * len(names))]
        layout = np.dtype(
            [
                (n if n != "_" else f"_{i}", k, (r,))
                for i, (n, k, r) in enumerate(zip(names, kinds, repeats, strict=True))
            ]
        )
    except (KeyError, ValueError, IndexError) as error:
        raise UserError(
            f"{path}: the PCD header lacks {error} or contradicts itself; it needs FIELDS, SIZE, TYPE, POINTS."
        ) from error
    if not 0 <= count <= MOST:
        raise UserError(f"{path}: {count} points; a view has at most {MOST}.")
    for axis in "xyz":
        if axis not in names:
            raise UserError(f"{path}: the cloud has no field '{axis}'; its fields are: {', '.join(names)}.")
    rows = _pcd_rows(header["DATA"][0], body, layout, count, path)
    points = np.stack([rows[a][:, 0].astype(float) for a in "xyz"], axis=1)
    return points, _packed_colours(rows)


def _pcd_header(data: bytes, path: Path) -> tuple[Mapping[str, list[str]], bytes]:
    header: dict[str, list[str]] = {}
    at = 0
    while at < len(data) and at < 10_000:
        end = data.find(b"\n", at)
        end = len(data) if end < 0 else end
        words = data[at:end].decode("latin-1").split()
        at = end + 1
        if words and not words[0].startswith("#"):
            header[words[0].upper()] = words[1:]
        if words[:1] == ["DATA"] and len(words) == 2:
            return header, data[at:]
    raise UserError(f"{path}: this is no PCD file: its header has no line 'DATA ascii' or 'DATA binary'.")


def _pcd_rows(form: str, body: bytes, layout: Any, count: int, path: Path) -> Any:
    if form == "binary":
        if len(body) < count * layout.itemsize:
            have = len(body) // layout.itemsize
            raise UserError(f"{path}: the file ends after {have} of {count} points; it was cut off.")
        return np.frombuffer(body, layout, count)
    if form != "ascii":
        raise UserError(f"{path}: PCD data is '{form}'; save it as 'ascii' or 'binary' (pcl_convert_pcd_ascii_binary).")
    flat = [(name, k) for name in layout.names for k in range(layout[name].shape[0])]
    try:
        table = np.array(body.split(), dtype=float).reshape(-1, len(flat))[:count]
    except ValueError as error:
        raise UserError(f"{path}: the points are not {len(flat)} numbers each: {error}.") from error
    if len(table) < count:
        raise UserError(f"{path}: the file ends after {len(table)} of {count} points; it was cut off.")
    rows = np.zeros(len(table), layout)
    for column, (name, k) in enumerate(flat):
        rows[name][:, k] = table[:, column]
    return rows


def _packed_colours(rows: Any) -> Any:
    """PCL packs red, green and blue into the bits of one 4 byte number, which it may call a float."""
    name = next((n for n in ("rgb", "rgba") if n in rows.dtype.names), None)
    if name is None or rows.dtype[name].base.itemsize != 4:
        return None
    bits = np.ascontiguousarray(rows[name][:, 0]).view(np.uint32)
    return np.stack([(bits >> shift) & 255 for shift in (16, 8, 0)], axis=1).astype(np.uint8)
