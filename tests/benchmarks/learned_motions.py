"""Motions learned from three recordings each, and done by two robots in worlds that nobody showed.

Three people show a motion that no rule and no task knows (``motion_demonstrations.py``). The package that is learned from them recognises
unseen people, and none of those who show it wrongly; with it, robots do the task in worlds of other seeds. A run counts if its program
was proven and this file's own look at the poses says that the motion was done.

    python tests/benchmarks/learned_motions.py [MOTION ...] [--first SEED] [--count N] [--robots ur5e fr3]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from figure import add_figure, rate, value, write
from motion_demonstrations import LINES, TOLD, WORLDS, WRONG, of, shown

from cramlite import Engine, Solution, Trace, read_scenario
from cramlite.interpretation.timeline import Timeline
from cramlite.learning.from_episodes import learn_task
from cramlite.learning.learner import covers
from cramlite.learning.package import write_package
from cramlite.learning.proposal import Proposal
from cramlite.learning.span import Span
from cramlite.model import Episode, Pose, Thing
from cramlite.plugin import Candidate

TEACHERS = (1, 2, 3)
ROLES = ("Patient", "Relatum", "Destination")
"""Names that learning gives to the roles of ``TOLD``."""
BASES: Mapping[str, str] = {"ur5e": "", "fr3": ", at: {position: [0.05, 0, 0]}"}


def places(episode: Episode, tool: Thing, about: Thing, part: Pose) -> np.ndarray:
    """Places (N, 3) of the middle of a block's lower face in the frame of a part of another thing [m]."""
    foot, found = tool.features[0].pose, []
    for time_ in episode.tracks[tool.name].times:
        frame = episode.pose_at(about.name, float(time_)) * part  # type: ignore[operator]
        found.append((frame.inverse() * episode.pose_at(tool.name, float(time_)) * foot).position)  # type: ignore[operator]
    return np.array(found)


def stirred(candidate: Candidate, spoon: Thing, bowl: Thing) -> bool:
    """Whether the spoon went round twice or more, lower than the rim and at least 15 mm from the middle."""
    cavity = bowl.feature("cram:Cavity")
    assert cavity is not None
    at = places(_episode(candidate), spoon, bowl, cavity.pose)
    inside = at[(at[:, 2] < -0.01) & (np.hypot(at[:, 0], at[:, 1]) > 0.015)]
    if len(inside) < 10:
        return False
    angles = np.unwrap(np.arctan2(inside[:, 1], inside[:, 0]))
    return bool(abs(angles[-1] - angles[0]) > 2 * 2 * np.pi)


def wiped(candidate: Candidate, sponge: Thing, board: Thing) -> bool:
    """Whether the sponge came within 12 mm of each corner of the pattern, in order, less than 4 mm over the board all the way."""
    at = places(_episode(candidate), sponge, board, Pose())
    corners, low, reached = [*LINES], at[:, 2] < 0.004, list[int]()
    begin = 0
    for corner in corners:
        near = np.flatnonzero(low[begin:] & (np.linalg.norm(at[begin:, :2] - corner, axis=1) < 0.012))
        if not len(near):
            return False
        begin += int(near[0])
        reached.append(begin)
    return bool(low[reached[0] : reached[-1]].mean() > 0.95)


def weighed(candidate: Candidate, box: Thing, scale: Thing) -> bool:
    """Whether the box stands on the scale at the end, within 2 mm, with the hand 50 mm away and still for 1.5 s or more."""
    episode = _episode(candidate)
    at = places(episode, box, scale, Pose())[-1]
    hand = episode.tracks[episode.effector or ""]
    last = hand.poses[hand.times >= hand.times[-1] - 1.5, :3]
    away = float(np.linalg.norm(last[-1] - episode.tracks[box.name].poses[-1, :3]))
    return bool(abs(at[2]) < 0.002 and np.abs(at[:2]).max() < 0.1 and away > 0.05 and np.ptp(last, axis=0).max() < 0.005)


def swept(candidate: Candidate, _brush: Thing, board: Thing) -> bool:
    """Whether nine of ten grains that lay on the board are within the walls of the pan at the end."""
    assert candidate.rollout is not None
    grains, pan = candidate.rollout.grains[board.name][-1], candidate.world.thing("pan")
    x, y, z = np.array(pan.pose.inverse().apply(grains)).T
    return bool(((abs(x) < 0.13) & (abs(y) < 0.09) & (z > 0.0) & (z < 0.055)).mean() >= 0.9)


def screwed(candidate: Candidate, lid: Thing, _about: Thing) -> bool:
    """Whether the lid is lower by two turns of its thread, a quarter of a turn more or less, and the hand has let go of it."""
    episode, joint = _episode(candidate), lid.joint
    assert joint is not None
    heights, hand = episode.tracks[lid.name].poses[:, 2], episode.tracks[episode.effector or ""].poses[-1, :3]
    turns = float(heights[0] - heights[-1]) / joint.pitch
    return bool(abs(turns - 2.0) < 0.25 and hand[2] - heights[-1] > 0.08)


def _episode(candidate: Candidate) -> Episode:
    assert candidate.episode is not None
    return candidate.episode


DONE: Mapping[str, Callable[[Candidate, Thing, Thing], bool]] = {
    "stirring": stirred, "wiping_lines": wiped, "weighing": weighed, "sweeping": swept,
    "screwing": screwed,
}  # fmt: skip


def taught(engine: Engine, motion: str, folder: Path) -> tuple[Proposal, Path, float]:
    """What is learned of a motion, the module of its package, and the time of learning [s of CPU]."""
    people = [shown(engine, motion, seed, folder) for seed in TEACHERS]
    assert not any(p.failure for p in people), [p.failure for p in people]
    begun = time.process_time()
    proposal = learn_task(motion, [(p.episode, p.start, p.end) for p in people], engine.knowledge)
    took = time.process_time() - begun
    written = write_package(proposal, motion, folder / f"package_{motion}")
    return proposal, next(p for p in written if p.name == "__init__.py"), took


def recognised(engine: Engine, proposal: Proposal, motion: str, seeds: range, folder: Path) -> tuple[int, int, int, int]:
    """Unseen people whose motion is recognised, of how many; and those who show it wrongly, likewise."""

    def known(episode: Episode, start: float, end: float) -> bool:
        span = Span(Timeline(episode, engine.knowledge.taxonomy), start, end)
        told = dict(zip(ROLES, TOLD[motion], strict=False))
        return any(dict(zip(proposal.roles, found, strict=True)) == told for found in covers(proposal.learned, span))

    right = [shown(engine, motion, seed, folder) for seed in seeds]
    wrong = [shown(engine, motion, seed, folder, {motion: script}) for script in WRONG[motion].values() for seed in seeds]
    hits, false = ([known(p.episode, p.start, p.end) for p in people if not p.failure] for people in (right, wrong))
    return sum(hits), len(hits), sum(false), len(false)


def job(motion: str, robot: str, folder: Path) -> Path:
    """Scenario in which a robot takes the tool and does what was learned."""
    path = folder / f"{motion}_{robot}.yaml"
    roles = ", ".join(f"{role}: {thing}" for role, thing in zip(ROLES, TOLD[motion], strict=False))
    task = f"  - {{task: {''.join(p.title() for p in motion.split('_'))}, {roles}}}\n"
    text = WORLDS[motion].replace("robot: {type: ur5e}", f"{task}robot: {{type: {robot}{BASES[robot]}}}")
    path.write_text(text, encoding="utf-8")
    return path


def solved(engine: Engine, motion: str, robot: str, seed: int, folder: Path, trace: Trace) -> Solution | None:
    """The first program with which a robot does what was learned in the world of a seed."""
    scenario = read_scenario(job(motion, robot, folder))
    return next(engine.resolve(scenario, setting=engine.setting(scenario, seed=seed, twins=0), seed=seed, trace=trace), None)


def robot_does(engine: Engine, motion: str, robot: str, seed: int, folder: Path) -> bool:
    """Whether a robot does what was learned in the world of a seed."""
    trace = Trace()
    solution = solved(engine, motion, robot, seed, folder, trace)
    if solution is None:
        print(motion, robot, seed, "no program:", "; ".join(e.reason for e in trace.entries)[-400:], flush=True)
        return False
    done = DONE[motion](solution.candidate, *of(motion, solution.candidate.world))
    print(motion, robot, seed, "done" if done else "proven, but not done", flush=True)
    return done


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("motions", nargs="*", default=[*DONE])
    parser.add_argument("--first", type=int, default=11)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--robots", nargs="+", default=[*BASES])
    add_figure(parser)
    arguments = parser.parse_args()
    seeds, numbers, times = range(arguments.first, arguments.first + arguments.count), [], []
    with tempfile.TemporaryDirectory() as name:
        folder, engine = Path(name), Engine()
        for motion in arguments.motions:
            proposal, module, took = taught(engine, motion, folder)
            times.append(took)
            said = motion.replace("_", " ")
            hits, of, false, wrong = recognised(engine, proposal, motion, seeds, folder)
            numbers.append(rate(f"{said}: unseen people recognised", hits, of))
            numbers.append(rate(f"{said}: other motions that are recognised", false, wrong))
            robots = Engine(files=[module])
            for robot in arguments.robots:
                done = sum(robot_does(robots, motion, robot, seed, folder) for seed in seeds)
                numbers.append(rate(f"{said}: worlds in which the {robot} does it", done, len(seeds)))
    numbers.append(value("longest time of learning [s of CPU]", round(max(times), 1)))
    write(arguments, numbers, seeds)
    print(numbers)


if __name__ == "__main__":
    main()
