"""Reader and writer of KnowRob's mongodump layout: ``<episode>/<collection>/roslog/<collection>.bson`` and ``.metadata.json``.

Documents are decoded one at a time, so that memory holds numbers only, whatever the file's size.

``header.stamp`` is a BSON date, which has milliseconds only. So each document that cramlite writes
has a field ``time`` with the same instant as a double; it also tells our own files from others, in
which an identity pose means that the tracker saw nothing.
"""

from __future__ import annotations

import gzip
import struct
import zlib
from array import array
from collections.abc import Iterable, Iterator
from datetime import datetime
from pathlib import Path
from typing import IO, Any, NamedTuple

import bson
import numpy as np
from bson.codec_options import CodecOptions, DatetimeConversion
from bson.datetime_ms import DatetimeMS
from numpy.typing import NDArray

from cramlite.model import Floats, Track
from cramlite.plugin import UserError

from ..tracks import Rows

ENDINGS = (".bson", ".bson.gz", ".json")
COLLECTIONS = ("tf", "triples", "annotations", "wrench", "inferred", "world_state")
#: MongoDB's own limit is 16 MB a document; twice that is certainly no document.
MAX_DOCUMENT = 32 * 2**20
#: The frame that our tracks are given in; KnowRob's name for the world.
WORLD_FRAME = "map"
#: Statements kept in memory, at about 0.5 kB each; an hour of KnowRob's logs has some 100,000.
MAX_TRIPLES = 1_000_000
#: A number as large as the first is no time in seconds (3000 years) but in the unit of the second [s].
UNITS = ((1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3))
_OPTIONS: CodecOptions[dict[str, Any]] = CodecOptions(datetime_conversion=DatetimeConversion.DATETIME_MS)


class Triple(NamedTuple):
    """RDF statement: ``o`` is an IRI or a literal as text, or a number."""

    s: str
    p: str
    o: str | float


def collection_files(folder: Path, name: str) -> list[Path]:
    """Find the files of a collection, in any of the layouts in use: at most one for each episode in the folder.

    KnowRob's ``tf/roslog/tf.bson``, also under a topic's name (``ros_tf``); a database's dump, in which each episode's collections
    begin with its id (``5fb3_tf.bson``), as openEASE keeps them; and each of them packed, or exported as JSON.
    """
    ends = ENDINGS[: 2 if name == "world_state" else 3]  # a world state in JSON has a reader of its own
    plain = [d / f"{name}{end}" for d in (folder / name / "roslog", folder / "roslog", folder, folder / name) for end in ends]
    found = next((p for p in plain if p.is_file()), None)
    if found is not None:
        return [found]
    patterns = (pattern + end for pattern in (f"*/roslog/{name}", f"*_{name}") for end in ENDINGS[:2])
    return sorted(f for pattern in patterns for f in folder.glob(pattern) if f.is_file())


def kind_of(file: Path) -> str:
    """Return the name of the collection that a file holds: the end of the file's name, after any id and
    underscore; the whole stem if it names no known collection."""
    stem = next((file.name.removesuffix(end) for end in ENDINGS if file.name.endswith(end)), file.stem)
    return next((c for c in COLLECTIONS if stem == c or stem.endswith(f"_{c}")), stem)


def documents(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the documents of a collection: BSON, packed or not, or JSON as mongoexport writes it, one document a line or a list.

    Raises:
        UserError: the file is cut off or is no BSON or JSON; names the document and the byte or line.
    """
    if path.suffix == ".json":
        yield from _exported(path)
        return
    with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as file:
        try:
            yield from _decoded(path, file)
        except (EOFError, gzip.BadGzipFile, zlib.error) as error:
            raise UserError(f"{path}: it cannot be unpacked: {error}. Dump the database again, or remove the file.") from None


def _exported(path: Path) -> Iterator[dict[str, Any]]:
    from bson.json_util import JSONOptions, loads

    options = JSONOptions(datetime_conversion=DatetimeConversion.DATETIME_MS)
    if path.stat().st_size > MAX_DOCUMENT and path.open("rb").read(1) == b"[":
        raise UserError(f"{path}: a list of {path.stat().st_size} bytes; export it without --jsonArray, one document a line.")
    with path.open(encoding="utf-8", errors="replace") as file:
        lines = iter([file.read()]) if file.read(1) == "[" and not file.seek(0) else file
        if lines is file:
            file.seek(0)
        for number, line in enumerate(lines, 1):
            try:
                found = loads(line, json_options=options) if line.strip() else []
            except (bson.errors.BSONError, ValueError, TypeError) as error:
                raise UserError(f"{path}:{number}: no document as mongoexport writes it: {error}.") from None
            for document in found if isinstance(found, list) else [found]:
                if not isinstance(document, dict):
                    raise UserError(f"{path}:{number}: a document is an object, not {str(document)[:40]!r}.")
                yield document


def _decoded(path: Path, file: IO[bytes] | gzip.GzipFile) -> Iterator[dict[str, Any]]:
    count = place = 0
    while head := file.read(4):
        size = struct.unpack("<i", head)[0] if len(head) == 4 else -1
        if len(head) == 4 and not 5 <= size <= MAX_DOCUMENT:
            raise _broken(path, count, place, f"its length is given as {size} bytes, so this is no BSON document")
        body = head + file.read(max(size - 4, 0))
        if len(body) != size:
            raise _broken(path, count, place, f"the file ends {size - len(body) if size > 0 else 'some'} bytes early")
        try:
            yield bson.decode(body, _OPTIONS)
        except (bson.errors.BSONError, ValueError) as error:
            raise _broken(path, count, place, str(error)) from None
        count, place = count + 1, place + size


def _broken(path: Path, count: int, place: int, why: str) -> UserError:
    return UserError(
        f"{path}: document {count} at byte {place} cannot be read: {why}. A whole collection, as mongodump "
        "writes it, is needed; dump the database again, or remove the file to read the episode without it."
    )


def read_tf(path: Path) -> dict[str, Rows]:
    """Read the poses of each child frame, as recorded: child -> rows, in file order.

    Raises:
        UserError: a document has no transform.
    """
    rows: dict[str, tuple[array[float], array[int], dict[str, int]]] = {}
    ours = True
    for count, document in _single(documents(path)):
        try:
            header, child, transform = document.get("header", document), document["child_frame_id"], document["transform"]
            t, q = (_named(transform[key], axes) for key, axes in (("translation", "xyz"), ("rotation", "xyzw")))
            time = document.get("time")
            if time is None:
                ours, time = False, seconds(header["stamp"])
            numbers, parents, names = rows.setdefault(str(child).lstrip("/"), (array("d"), array("i"), {}))
            numbers.extend((time, t["x"], t["y"], t["z"], q["w"], q["x"], q["y"], q["z"]))
            parents.append(names.setdefault(header["frame_id"].lstrip("/"), len(names)))
        except (KeyError, TypeError, AttributeError, ValueError) as error:
            raise _not_a(path, count, "transform", error) from None
    return {child: _rows(*columns, ours) for child, columns in rows.items()}


def _named(values: Any, axes: str) -> Any:
    """Vector or quaternion as a dictionary from axis name to number; some writers give a list instead."""
    return dict(zip(axes, values, strict=True)) if isinstance(values, list) else values


def _single(found: Iterable[dict[str, Any]]) -> Iterator[tuple[int, dict[str, Any]]]:
    """Transforms of documents, each with the number of its document; a document is a single transform, or a tf message with a list of
    transforms."""
    for count, document in enumerate(found):
        many = document.get("transforms")
        yield from ((count, one) for one in (many if isinstance(many, list) else [document]))


def _rows(numbers: array[float], parents: array[int], names: dict[str, int], ours: bool) -> Rows:
    table = np.frombuffer(numbers, dtype=float).reshape(-1, 8)
    return Rows(
        table[:, 0].copy(), table[:, 1:].copy(), np.frombuffer(parents, dtype=np.int32).copy(), tuple(names), ours
    )


def read_wrench(path: Path) -> tuple[Floats, Floats]:
    """Read times (N,) [s] and wrenches (N, 6) [N, Nm], of either layout: under ``force`` in older, ``wrench`` in newer dumps."""
    times, values = array("d"), array("d")
    for count, document in enumerate(documents(path)):
        try:
            value = document["wrench"] if "wrench" in document else document["force"]
            times.append(document["time"] if "time" in document else seconds(document["header"]["stamp"]))
            values.extend(value[kind][axis] for kind in ("force", "torque") for axis in "xyz")
        except (KeyError, TypeError, ValueError) as error:
            raise _not_a(path, count, "wrench", error) from None
    return np.array(times, dtype=float), np.array(values, dtype=float).reshape(-1, 6)


def read_triples(path: Path) -> list[Triple]:
    """Read the statements of a triples, annotations or inferred collection."""
    found = []
    for count, document in enumerate(documents(path)):
        if count >= MAX_TRIPLES:
            raise UserError(f"{path}: more than {MAX_TRIPLES} statements; split the dump, one episode in each folder.")
        try:
            value = document["o"] if "o" in document else document["v"]
            found.append(Triple(str(document["s"]), str(document["p"]), value if _is_number(value) else str(value)))
        except (KeyError, TypeError) as error:
            raise _not_a(path, count, "triple", error) from None
    return found


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _not_a(path: Path, count: int, what: str, error: Exception) -> UserError:
    missing = f"field {error} is missing" if isinstance(error, KeyError) else str(error)
    return UserError(
        f"{path}: document {count} is no {what}: {missing}. See reference 'mongodump layout' for its fields."
    )


def seconds(stamp: object) -> float:
    """Convert a time stamp to seconds: a BSON date, a number of s, ms, us or ns, ISO 8601, {secs, nsecs} of ROS 1, {sec, nanosec} of ROS 2.

    Raises:
        TypeError, ValueError: it is none of these.
    """
    if isinstance(stamp, DatetimeMS):
        return int(stamp) / 1000.0
    if isinstance(stamp, dict):
        whole, part = ("sec", "nanosec") if "sec" in stamp else ("secs", "nsecs")
        return float(stamp[whole]) + float(stamp[part]) * 1e-9
    if isinstance(stamp, str) and "-" in stamp[1:]:
        return datetime.fromisoformat(stamp).timestamp()
    time = float(stamp)  # type: ignore[arg-type]
    unit = next((u for least, u in UNITS if abs(time) >= least), 1.0)
    return time * unit


def write_tf(tracks: dict[str, Track], folder: Path) -> None:
    """Write tracks as the tf collection, with poses and times unchanged."""
    _write(folder, "tf", (chunk for name, track in tracks.items() for chunk in _transforms(name, track)))


def _transforms(name: str, track: Track) -> Iterator[bytes]:
    """Encode a track as documents of the tf collection (BSON), one for each pose, many at a time.

    All documents of one frame have the same number of bytes, so only the first is encoded, and its numbers
    are replaced in copies.

    Twenty times faster than encoding each, which a million poses need.
    """
    numbers = [float(7 + k) for k in range(8)]
    first = bson.encode(_transform(name, 2_000_000_011, 2_000_000_011_000, numbers))
    template = np.frombuffer(first, dtype=np.uint8)
    tail = first.index(b"\x03transform\x00")
    seq, stamp = (first.index(struct.pack(f, v)) for f, v in (("<i", 2_000_000_011), ("<q", 2_000_000_011_000)))
    places = [first.index(struct.pack("<d", v), tail) for v in numbers]
    columns = np.column_stack([track.times, track.poses])
    for start in range(0, len(columns), 10_000):
        part = columns[start : start + 10_000]
        rows = np.tile(template, (len(part), 1))
        _put(rows, seq, np.arange(start, start + len(part), dtype="<i4"))
        _put(rows, stamp, np.round(part[:, 0] * 1000).astype("<i8"))
        for k, place in enumerate(places):
            _put(rows, place, part[:, k].astype("<f8"))
        yield rows.tobytes()


def _put(rows: NDArray[np.uint8], place: int, column: NDArray[Any]) -> None:
    """Write the numbers of a column (N,) into the byte rows (N, bytes), from the byte ``place`` on."""
    rows[:, place : place + column.itemsize] = np.ascontiguousarray(column).view(np.uint8).reshape(len(rows), -1)


def _transform(name: str, seq: int, milliseconds: int, numbers: list[float]) -> dict[str, Any]:
    """One document of the tf collection: the pose of a frame; ``numbers`` are time, position and quaternion
    (w, x, y, z)."""
    time, x, y, z, qw, qx, qy, qz = numbers
    transform = {"translation": {"x": x, "y": y, "z": z}, "rotation": {"x": qx, "y": qy, "z": qz, "w": qw}}
    header = {"seq": seq, "stamp": DatetimeMS(milliseconds), "frame_id": WORLD_FRAME}
    return {"header": header, "child_frame_id": name, "transform": transform, "time": time}


def write_wrench(times: Floats, wrenches: Floats, frame: str, folder: Path) -> None:
    """Write the wrench collection as newer dumps have it: force and torque in a field ``wrench``."""
    _write(
        folder,
        "wrench",
        (_wrench(k, t, w, frame) for k, (t, w) in enumerate(zip(times.tolist(), wrenches, strict=True))),
    )


def _wrench(seq: int, time: float, wrench: Floats, frame: str) -> bytes:
    force, torque = (dict(zip("xyz", half.tolist(), strict=True)) for half in (wrench[:3], wrench[3:]))
    header = {"seq": seq, "stamp": DatetimeMS(round(time * 1000)), "frame_id": frame}
    return bytes(bson.encode({"header": header, "wrench": {"force": force, "torque": torque}, "time": time}))


def write_triples(triples: Iterable[Triple], folder: Path) -> None:
    """Write the triples collection; the scope of every statement is unlimited time, in KnowRob's format."""
    scope = {"time": {"since": 0.0, "until": float("inf")}}
    rows = ({"s": t.s, "p": t.p, "o": t.o, "graph": "user", "scope": scope} for t in triples)
    _write(folder, "triples", map(bson.encode, rows))


def _write(folder: Path, name: str, stream: Iterable[bytes]) -> None:
    place = folder / name / "roslog"
    place.mkdir(parents=True, exist_ok=True)
    with (place / f"{name}.bson").open("wb") as file:
        file.writelines(stream)
    index = '{"v":{"$numberInt":"2"},"key":{"_id":{"$numberInt":"1"}},"name":"_id_"}'
    metadata = f'{{"indexes":[{index}],"collectionName":"{name}","type":"collection"}}'
    (place / f"{name}.metadata.json").write_text(metadata, encoding="utf-8")
