"""An episode of a million poses: written, read, compared; against bare BSON decoding of the same file.

Run: python tests/benchmarks/episodes.py [--poses 1000000] [--seed 0]

Goals: less than 20 s and 1 GB for the round trip. Seconds depend on the machine and on other load; the ratio to
decoding the same documents with pymongo's ``bson`` alone, in the same run, hardly does. Queries are timed too.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from pathlib import Path

import bson
import numpy as np
from figure import add_figure, value, write

from cramlite.model import Entity, Episode, Event, Track
from cramlite_plugins.episodes.formats.neem import read_neem, write_neem


def random_episode(poses: int, seed: int, frames: int = 10) -> Episode:
    """Frames with equally many poses, and an event for every thousandth."""
    rng = np.random.default_rng(seed)
    tracks = {}
    for k in range(frames):
        turned = rng.normal(size=(poses // frames, 4))
        turned /= np.linalg.norm(turned, axis=1)[:, None]
        times = np.cumsum(rng.random(len(turned)) * 0.01)
        tracks[f"thing_{k}"] = Track(times, np.hstack([rng.normal(size=(len(turned), 3)), turned]))
    starts = np.sort(rng.uniform(0, tracks["thing_0"].times[-1], poses // 1000))
    roles = {"a": "thing_0", "b": "thing_1"}
    events = (Event(f"c{k}", "soma:ContactState", "state", float(t), float(t) + 1, roles) for k, t in enumerate(starts))
    return Episode("benchmark", tuple(Entity(n, ("cram:Product",)) for n in tracks), tuple(events), tracks)


def equal(a: Episode, b: Episode | None) -> bool:
    return b is not None and (a.entities, a.events) == (b.entities, b.events) and all(
        np.array_equal(t.times, b.tracks[n].times) and np.array_equal(t.poses, b.tracks[n].poses)
        for n, t in a.tracks.items()
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--poses", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    add_figure(parser)
    arguments = parser.parse_args()
    episode = random_episode(arguments.poses, arguments.seed)
    with tempfile.TemporaryDirectory() as name:
        began = time.perf_counter()
        write_neem(episode, name)
        written = time.perf_counter()
        found = read_neem(name)
        read = time.perf_counter()
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        assert equal(episode, found), "what was read differs from what was written"
        start = time.perf_counter()
        with (Path(name) / "tf" / "roslog" / "tf.bson").open("rb") as file:
            documents = sum(1 for _ in bson.decode_file_iter(file))
        bare = time.perf_counter() - start
    print(f"{documents} poses, {len(episode.events)} events: read back equal, peak memory {memory:.2f} GB")
    print(f"write {written - began:.2f} s, read {read - written:.2f} s, bare BSON decoding {bare:.2f} s")
    print(f"round trip {read - began:.2f} s, {(read - began) / bare:.1f} times bare decoding")
    queries = np.random.default_rng(arguments.seed).uniform(*episode.span, 10_000).tolist()
    start = time.perf_counter()
    for t in queries:
        episode.pose_at("thing_3", t)
    middle = time.perf_counter()
    for t in queries:
        episode.at(t)
    end = time.perf_counter()
    numbers = (
        value("write", written - began, "s"), value("read", read - written, "s"),
        value("round trip / bare BSON decoding", (read - began) / bare), value("peak memory", memory, "GB"),
        value("pose at a time", (middle - start) * 100, "us"),
    )  # fmt: skip
    write(arguments, numbers, f"seed {arguments.seed}")
    print(f"pose at a time {(middle - start) * 100:.1f} us, events at a time {(end - middle) * 100:.1f} us")


if __name__ == "__main__":
    main()
