"""What the import finds in scenes of others, how long reading takes, and the time of their state checks.

    python tests/benchmarks/foreign_scenes.py FOLDER            # every .xml and .urdf below it that is a scene of its own
    python tests/benchmarks/foreign_scenes.py FOLDER --checks   # and state checks with a UR5e where the scene's first robot stood

A file with keyframes is read in the first one that has a name. Times are CPU seconds of this one process, the file's hulls
not kept from before (``--kept``: as they are). A state check is a planning scene's ``free`` at random joint positions; the
raw figure is MuJoCo's kinematics and ``mj_collision`` of a model of the same scene at the same positions.
"""

from __future__ import annotations

import argparse
import os
import re
import tempfile
import time
from pathlib import Path

import mujoco
import numpy as np
from figure import add_figure, value, write

from cramlite.model import ImportedScene, Pose, RobotMount, World
from cramlite.plugin import UserError
from cramlite_plugins.imports.scenes.reader import read_scene
from cramlite_plugins.robots.arms import robots

ROBOTS = {r.type: r for r in robots()}
CHECKS = 400


def read(path: Path) -> tuple[ImportedScene | None, float]:
    """The scene in a file, in its first named keyframe, and the CPU seconds of reading it."""
    key = re.search(r'<key\s[^>]*name="([^"]+)"', path.read_text(errors="replace"))
    before = time.process_time()
    scene = read_scene(path, {}, key[1] if key else "", {})
    return scene, time.process_time() - before


def row(name: str, scene: ImportedScene, seconds: float) -> str:
    """One line of the table."""
    things = scene.things
    features = [f.type for t in things for f in t.features]
    counts = (
        len(things), sum(len(t.geoms) for t in things), sum(t.joint is not None for t in things),
        sum(t.joint is not None and t.feature("cram:Handle") is not None for t in things),
        features.count("vrps:SurfaceFeature"), features.count("cram:Cavity"),
    )  # fmt: skip
    return f"| {name} | " + " | ".join(map(str, counts)) + f" | {seconds:.1f} |"


def checks(scene: ImportedScene) -> tuple[float, float]:
    """CPU microseconds of a state check, and of raw kinematics with ``mj_collision``."""
    from cramlite_plugins.motion_planning.scene_of_world import scene as planning_scene

    stand = next(iter(scene.stands.values()), Pose())
    world = World(scene.things, robots=(RobotMount("arm", "ur5e", stand),))
    place, rng = planning_scene(world, ROBOTS, "arm"), np.random.default_rng(0)
    low, high = np.array(place.limits).T
    positions = rng.uniform(np.maximum(low, -3), np.minimum(high, 3), (CHECKS, len(low)))
    best = [min(_timed(place, positions, raw) for _ in range(3)) for raw in (False, True)]
    return best[0], best[1]


def _timed(place: object, positions: np.ndarray, raw: bool) -> float:
    model, data, index = place.compiled.model, place.data, place.index  # type: ignore[attr-defined]
    first, before = index.joints[0], time.process_time()
    for q in positions:
        if raw:
            data.qpos[first : first + len(q)] = q
            mujoco.mj_kinematics(model, data)
            mujoco.mj_collision(model, data)
        else:
            place.free(q)  # type: ignore[attr-defined]
    return 1e6 * (time.process_time() - before) / len(positions)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--checks", action="store_true")
    parser.add_argument("--kept", action="store_true", help="use hulls that were kept")
    add_figure(parser)
    options = parser.parse_args()
    if not options.kept:
        os.environ["XDG_CACHE_HOME"] = tempfile.mkdtemp()
    more = " state check | raw | ratio |" if options.checks else ""
    print(
        "| scene | things | shapes | joints | handles | surfaces | cavities | seconds |" + more
        + "\n|---|---|---|---|---|---|---|---|" + "---|" * more.count("|")
    )
    numbers = []
    for path in sorted(p for kind in ("*.xml", "*.urdf") for p in options.folder.rglob(kind)):
        try:
            scene, seconds = read(path)
        except UserError as error:
            print(f"{path.stem}: {error}")
            continue
        if scene is not None:
            ours, raw = checks(scene) if options.checks else (0.0, 1.0)
            cost = f" {ours:.0f} us | {raw:.0f} us | {ours / raw:.1f} |" if options.checks else ""
            numbers.append(value(path.stem, seconds, "s", "read"))
            numbers += [value(path.stem, ours / raw, "times mj_collision", "state check")] if options.checks else []
            print(row(path.stem, scene, seconds) + cost, flush=True)
    write(options, numbers)


if __name__ == "__main__":
    main()
