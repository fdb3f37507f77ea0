"""NEEMs on disk: an episode as a folder of files in the formats of RobCoG and KnowRob, written and read
without loss.

    <Id>_ED.owl              events, RobCoG event data
    <Id>_SM.owl              entities, RobCoG semantic map
    tf/roslog/tf.bson        poses, KnowRob's mongodump layout
    wrench/roslog/...        forces, where there are some
    triples/roslog/...       the same events and entities as SOMA triples
    extras.npz               further arrays (joints, gripper opening), NumPy's format

Any of these may be absent. Events and entities are taken from RobCoG's files, else from triples or RDF.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from cramlite.model import Episode
from cramlite.plugin import UserError

from . import mongodump, robcog_writer, soma
from .complete import episode_of
from .parts import RDF, Parts, add_triples, read_file


def write_neem(episode: Episode, folder: Path | str) -> Path:
    """Write an episode; ``read_neem`` gives an equal one back, times and poses to the last bit.

    Args:
        folder: is created; files of an earlier episode of the same name are replaced. A name that ends in .ttl or .nt
            is a file instead: entities and events as RDF, without poses.

    Returns:
        The folder or file.

    Raises:
        UserError: the folder cannot be written to, or something that moves has a name that tf does not keep.
    """
    folder = Path(folder)
    if slashed := next((n for n in episode.tracks if n.startswith("/")), None):
        kept = slashed.lstrip("/") or "thing"
        raise UserError(f"{folder}: the name '{slashed}' would not read back: tf drops leading slashes; call it '{kept}'.")
    id_ = re.sub(r"[^\w.-]+", "_", episode.name) or "episode"
    try:
        if folder.suffix.lower() in (".ttl", ".nt"):
            folder.write_text("".join(soma.ntriples(soma.triples_of(episode))), encoding="utf-8")
            return folder
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{id_}_ED.owl").write_text(robcog_writer.event_data(episode, id_, f"{id_}_map"), encoding="utf-8")
        (folder / f"{id_}_SM.owl").write_text(robcog_writer.semantic_map(episode, f"{id_}_map"), encoding="utf-8")
        mongodump.write_tf(episode.tracks, folder)
        mongodump.write_triples(soma.triples_of(episode), folder)
        _write_extras(episode, folder)
    except OSError as error:
        raise UserError(
            f"{folder}: the episode cannot be written: {error.strerror or error}. Choose another folder."
        ) from None
    return folder


def _write_extras(episode: Episode, folder: Path) -> None:
    """Write an episode's wrenches to the wrench collection, and all other extras to extras.npz."""
    rest = dict(episode.extras)
    times, wrench = rest.get("times"), rest.get("wrench")
    if times is not None and wrench is not None and wrench.shape == (len(times), 6) and wrench.any():
        mongodump.write_wrench(times, rest.pop("wrench"), episode.effector or "sensor", folder)
    if rest:
        np.savez_compressed(folder / "extras.npz", **rest)  # type: ignore[arg-type]


def read_neem(path: Path | str) -> Episode | None:
    """Read the episode in a folder or file; None if there is no NEEM.

    Reads RobCoG event data, semantic maps and world states, KnowRob mongodumps and NEEMs as RDF, alone
    or together; see the module's docstring for the names. Repairs are listed in the episode.

    Raises:
        UserError: a file cannot be read; names the file, the place and what to do.
    """
    path = _episode_in(Path(path))
    parts = Parts(re.sub(r"_(ED|SM|WS)$", "", path.stem if path.is_file() else path.resolve().name))
    for file in _files(path):
        try:
            read_file(file, parts)
        except OSError as error:
            raise UserError(f"{file}: cannot be read: {error.strerror or error}.") from None
    add_triples(parts)
    return episode_of(parts) if parts.found else None


def _files(path: Path) -> list[Path]:
    """Files of one episode in reading order: semantic maps and event data first, since triples add only what
    these lack."""
    if path.is_file():
        return [path]
    owl = sorted(f for f in path.glob("*") if f.is_file() and f.suffix.lower() in RDF)
    logs = [f for f in owl if f.stem.endswith("_ED")]
    if len(logs) > 1:
        raise UserError(
            f"{path}: holds {len(logs)} episodes ({', '.join(f.name for f in logs)}). Name one of the files, "
            "or put each episode into a folder of its own."
        )
    states = sorted(f for pattern in ("*_WS.json", "*world_state*.json", "*.jsonl") for f in path.glob(pattern))
    dumps = _dumps(path)
    extras = [f for f in (path / "extras.npz",) if f.is_file()]
    return [
        *sorted(owl, key=lambda f: (not f.stem.endswith("_SM"), not f.stem.endswith("_ED"))),
        *states,
        *dumps,
        *extras,
    ]


def _dumps(path: Path) -> list[Path]:
    """Files of all mongodump collections of the one episode in a folder."""
    found = {name: mongodump.collection_files(path, name) for name in mongodump.COLLECTIONS}
    if many := max(found.values(), key=len)[1:]:
        raise UserError(
            f"{path}: holds {len(many) + 1} episodes ({', '.join(str(f.relative_to(path)) for f in max(found.values(), key=len)[:5])}"
            f"{', ...' if len(many) > 4 else ''}). Name one of the files, or put each episode into a folder of its own."
        )
    return [f for files in found.values() for f in files]


def _episode_in(path: Path) -> Path:
    """Folder of an episode: the given one if it holds an episode, else its only subfolder that holds one.

    Raises:
        UserError: several do.
    """
    if path.is_file() or _files(path) or any(path.glob("*.yaml")):
        return path
    inner = [f for f in sorted(path.glob("*")) if f.is_dir() and not f.name.startswith(".") and _files(f)]
    if len(inner) > 1:
        some = ", ".join(f.name for f in inner[:5]) + (", ..." if len(inner) > 5 else "")
        raise UserError(f"{path}: holds {len(inner)} episodes ({some}). Name one of these folders.")
    return inner[0] if inner else path
