"""Check of an executed program by its camera: a picture after each task, and one at rest, against what the proof predicts.

Pictures tell only of the things that the proof moved until then, and of those that the goal is about. Nothing is stopped:
deviations are reported with the execution.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from ..base.value import Value
from ..base.word import Word
from ..model.designator_name import task_of
from ..model.entity_name import thing_of
from ..model.run.readings import Deviation, Notice
from ..model.run.rollout import world_in_run
from ..perception.sightings import ENOUGH, Seen, Sighting, sightings

if TYPE_CHECKING:
    from ..model.program.program import Code
    from ..model.run.rollout import Rollout
    from ..model.world.world import World
    from ..plugin.catalogue import Knowledge
    from ..plugin.protocols import Candidate

MOVED = 0.02
"""Least distance by which the proof must move a thing so that pictures check its place [m]."""
NOISE = 15485863
"""Added to the seed for each picture's noise, so that no picture repeats the noise of another one."""


class Looks(Word):
    """Judgement of the last picture of an execution: whether its goal looks reached."""

    REACHED = "looks reached", "all things of the goal are where the proof had them at its end"
    MISSED = "does not look reached", "a thing of the goal is not where the proof had it at its end"
    UNSEEN = "could not be seen", "no thing of the goal is seen elsewhere, and not all of them are seen"


class PictureCheck(Value):
    """Picture taken during an execution, compared with what the proof predicts.

    Args:
        task: designator of the task after which it was taken; "" for the last picture, at rest.
        time: of the run [s].
        things: comparison for each thing that was looked at.
    """

    task: str
    time: float
    things: tuple[Sighting, ...]


class PictureChecks(Value):
    """Pictures of an execution, and what they tell of its goal.

    Args:
        pictures: in the order in which they were taken; the last one at rest.
        notices: things that were not where the proof had them, each when it was first noticed.
        looks: whether the goal looks reached at rest.
        reason: numbers behind that, as a clause.
    """

    pictures: tuple[PictureCheck, ...]
    notices: tuple[Notice, ...]
    looks: Looks
    reason: str

    def __str__(self) -> str:
        """Return one line: whether the goal looks reached, and why."""
        return f"the goal {self.looks}: {self.reason}"


def picture_checks(proof: Candidate, code: Code, run: Rollout, real: World, knowledge: Knowledge, seed: int) -> PictureChecks | None:
    """Take the pictures that the world's camera is to take in a run, and compare them with the proof.

    Args:
        proof: the program, with the rollout of its proof.
        code: the text that ran.
        run: of that text in the real world.

    Returns:
        None if no camera is to check anything, or the program was not proven by running it.
    """
    camera = next((c for c in proof.world.cameras if c.checks != "none"), None)
    if camera is None or proof.rollout is None:
        return None
    expected, done = proof.rollout, task_ends(run, code.origins)
    ends = task_ends(expected, code.origins)
    between = [t for t in done if t in ends] if camera.checks == "tasks" else []
    taken: list[PictureCheck] = []
    for number, (task, then, now) in enumerate([*((t, ends[t], done[t]) for t in between[:-1]), ("", -1, -1)]):
        there, names = world_in_run(run, real, now), _told_of(expected, proof, then)
        believed = replace(world_in_run(expected, proof.world, then), robots=there.robots)
        placed = replace(camera, joints=there.robots[0].joints) if camera.mount is not None else camera
        view = knowledge.simulator.look(there, knowledge.robots_of(there), placed, seed=seed + NOISE * (number + 1))
        taken.append(PictureCheck(task, float(run.times[now]), sightings(view, placed, believed, names, knowledge)))
    last = [s for s in taken[-1].things if s.thing in (_of_goal(proof) or {s.thing})]
    looks, reason = _looks(last)
    return PictureChecks(tuple(taken), tuple(_notices(taken)), looks, reason)


def task_ends(rollout: Rollout, origins: Mapping[int, str]) -> dict[str, int]:
    """Return the last sample of each task of a run, by the task's designator, in the order in which the tasks began.

    Args:
        origins: program line -> designator of the step that begins there.
    """
    firsts, ends = sorted(origins), dict[str, int]()
    for sample in np.flatnonzero(rollout.lines > 0):
        before = bisect_right(firsts, int(rollout.lines[sample]))
        if before:
            ends[task_of(origins[firsts[before - 1]])] = int(sample)
    return ends


def _told_of(proof: Rollout, candidate: Candidate, sample: int) -> list[str]:
    """Return the things that pictures are to show at a sample of the proof: those that it moved until then, and at its end those of the
    goal."""
    world, goal = candidate.world, _of_goal(candidate) if sample == -1 else frozenset()
    tracks = {t.name: proof.poses[t.name] for t in world.things if t.movable and t.name in proof.poses}
    return [n for n, rows in tracks.items() if n in goal or float(np.linalg.norm(rows[sample, :3] - rows[0, :3])) > MOVED]


def _of_goal(candidate: Candidate) -> frozenset[str]:
    return frozenset(thing_of(n) for g in candidate.goal for n in g.things) & {t.name for t in candidate.world.things if t.movable}


def _notices(pictures: Iterable[PictureCheck]) -> Iterator[Notice]:
    """Generate a notice for each thing that is not where it should be, from the first picture that tells so."""
    gone: set[str] = set()
    for picture in pictures:
        for one in picture.things:
            if one.seen is Seen.GONE and one.thing not in gone:
                share = one.there / (one.there + one.gone)
                said = f"'{one.thing}' is not where it should be: {one.reason}"
                yield Notice(Deviation.MOVED, picture.time, said, picture.task, one.thing, share, ENOUGH)
        gone = {s.thing for s in picture.things if s.seen is Seen.GONE}


def _looks(things: Iterable[Sighting]) -> tuple[Looks, str]:
    """Return whether a goal looks reached by its things in the last picture, with the numbers of those that decide it."""
    by: dict[Seen, list[Sighting]] = {seen: [s for s in things if s.seen is seen] for seen in Seen}
    total = sum(map(len, by.values()))
    if by[Seen.GONE]:
        return Looks.MISSED, "; ".join(s.reason for s in by[Seen.GONE])
    if by[Seen.HIDDEN] or not total:
        return Looks.UNSEEN, "; ".join(s.reason for s in by[Seen.HIDDEN]) or "its tasks moved nothing that a picture can show"
    return Looks.REACHED, "; ".join(s.reason for s in by[Seen.THERE])
