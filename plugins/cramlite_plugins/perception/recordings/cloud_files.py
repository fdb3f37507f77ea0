"""Point cloud files: PLY by trimesh, PCD by a small reader of its three forms.

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
"""Largest number of points of a cloud that is read as a view: ten frames of the largest depth camera; a larger cloud is a map."""
TYPES = {("F", 4): "<f4", ("F", 8): "<f8", ("U", 1): "u1", ("U", 2): "<u2", ("U", 4): "<u4",
         ("I", 1): "i1", ("I", 2): "<i2", ("I", 4): "<i4"}  # fmt: skip


class Cloud(Value, eq=False):
    """Point cloud (N, 3) [m], all finite, with colours (N, 3) uint8 where the file has them.

    Args:
        size: (height, width) of the image that an organised cloud is of [pixel], else None.
        pixels: (N,) indices of its points in that image, row by row.
    """

    points: Points
    colours: NDArray[np.uint8] | None = None
    size: tuple[int, int] | None = None
    pixels: NDArray[np.int64] | None = None


def read_cloud(path: Path) -> Cloud:
    """Read a point cloud; points that are not finite, which organised clouds have, are left out.

    Raises:
        UserError: it cannot be read, has no points, or none that is finite.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: cannot be read: {error.strerror}.") from error
    points, colours, size = (_ply if path.suffix.lower() == ".ply" else _pcd)(data, path)
    if len(points) == 0:
        raise UserError(f"{path}: the cloud is empty.")
    finite = np.isfinite(points).all(1)
    if not finite.any():
        raise UserError(
            f"{path}: none of the {len(points)} points is finite; nothing was measured, or it was saved wrongly."
        )
    kept = None if colours is None else colours[finite].astype(np.uint8)
    return Cloud(points[finite].astype(float), kept, size, np.flatnonzero(finite) if size else None)


def _ply(data: bytes, path: Path) -> tuple[Any, Any, None]:
    import trimesh

    try:
        loaded = trimesh.load(io.BytesIO(data), file_type="ply", process=False)
        points = np.asarray(loaded.vertices, dtype=float).reshape(-1, 3)
    except Exception as error:  # trimesh's readers raise whatever their parsers do
        raise UserError(f"{path}: cannot be read as PLY ({type(error).__name__}: {str(error)[:100]}).") from error
    colours = getattr(getattr(loaded, "visual", None), "vertex_colors", getattr(loaded, "colors", None))
    colours = None if colours is None else np.asarray(colours)
    whole = colours is not None and colours.shape[:1] == points.shape[:1]
    return points, colours[:, :3] if whole and colours is not None else None, None


def _pcd(data: bytes, path: Path) -> tuple[Any, Any, tuple[int, int] | None]:
    rows, size = pcd_rows(data, path)
    for axis in "xyz":
        if axis not in rows.dtype.names:
            names = ", ".join(rows.dtype.names)
            raise UserError(f"{path}: the cloud has no field '{axis}'; its fields are: {names}.")
    points = np.stack([rows[a][:, 0].astype(float) for a in "xyz"], axis=1)
    return points, _packed_colours(rows), size


def pcd_rows(data: bytes, path: Path) -> tuple[Any, tuple[int, int] | None]:
    """Return the points of a PCD file with all fields, (N,) of a structured type, and an organised cloud's (height, width).

    Raises:
        UserError: it cannot be read.
    """
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
    return _pcd_rows(header["DATA"][0], body, layout, count, path), _organised(header, count)


def _organised(header: Mapping[str, list[str]], count: int) -> tuple[int, int] | None:
    """Height and width of the image that an organised cloud was made from; None for an unorganised cloud."""
    try:
        height, width = int(header["HEIGHT"][0]), int(header["WIDTH"][0])
    except (KeyError, ValueError, IndexError):
        return None
    return (height, width) if height > 1 and height * width == count else None


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
    if form == "binary_compressed":
        return _columns(body, layout, count, path)
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


def _columns(body: bytes, layout: Any, count: int, path: Path) -> Any:
    """Decode compressed points of a PCD file: its data begin with two 4-byte sizes, then come the fields one
    after the other, packed by LZF."""
    packed, size = (int(n) for n in np.frombuffer(body[:8].ljust(8, b"\0"), "<u4"))
    if size != count * layout.itemsize:
        raise UserError(f"{path}: {count} points need {count * layout.itemsize} bytes, and the data say {size}.")
    data = unpacked(body[8 : 8 + packed], size)
    if data is None:
        raise UserError(f"{path}: the compressed points are cut off or broken.")
    rows, at = np.zeros(count, layout), 0
    for name in layout.names:
        kind = layout[name]
        rows[name] = np.frombuffer(data, kind.base, count * kind.shape[0], at).reshape(count, -1)
        at += count * kind.itemsize
    return rows


def unpacked(data: bytes, size: int) -> bytes | None:
    """Return LZF data (liblzf 3.6) decompressed; None if the result is not of the given size."""
    out, at = bytearray(), 0
    try:
        while at < len(data) and len(out) <= size:
            token = data[at]
            at += 1
            if token < 32:  # so many bytes as they are
                out += data[at : at + token + 1]
                at += token + 1
                continue
            length = token >> 5
            if length == 7:
                length += data[at]
                at += 1
            start = len(out) - ((token & 31) << 8) - data[at] - 1
            at += 1
            if start < 0:
                return None
            part = out[start : start + length + 2]
            out += (part * ((length + 2) // len(part) + 1))[: length + 2]  # it may reach into itself
    except IndexError:
        return None
    return bytes(out) if len(out) == size else None


def _packed_colours(rows: Any) -> Any:
    """Colours (N, 3) of a PCD file: PCL packs red, green and blue into the bits of one 4 byte number,
    which it may call a float."""
    name = next((n for n in ("rgb", "rgba") if n in rows.dtype.names), None)
    if name is None or rows.dtype[name].base.itemsize != 4:
        return None
    bits = np.ascontiguousarray(rows[name][:, 0]).view(np.uint32)
    return np.stack([(bits >> shift) & 255 for shift in (16, 8, 0)], axis=1).astype(np.uint8)
