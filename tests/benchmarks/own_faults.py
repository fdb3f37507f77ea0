"""Faults of twelve kinds, drawn by a seed over camera scenarios, pouring and kitchens, each beside the same run without it.

``python tests/benchmarks/own_faults.py --out ROWS.jsonl [--first N] [--count N]`` appends a JSON line a run and runs no number twice: it
may be stopped, and goes on by the same command. Number n is a fault of kind n modulo 12, so that every prefix is balanced over kinds; sixty
numbers share their scenes. The rule of what one arm could mend is ``unmendable``; it looks at the draw alone, and was written before the
first run. A run is right if the goal holds in the simulator's own state at the end; or, of the others, if the arm stopped by itself with a
right diagnosis (``RIGHT``) and without a force above its limit.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from figure import add_figure, rate, value, write
from msgspec.structs import replace

from cramlite import Engine, NoSolution, Solution, UserError, find_scenario, read_scenario
from cramlite.engine.recovery.expectation import Expectation, Noise, RunWatch, expectation
from cramlite.engine.recovery.going_on import GoingOn, Stretch
from cramlite.engine.recovery.replanning import Attempt, Round
from cramlite.experiment.figure import Number
from cramlite.model import Geom, Pose, Thing, World
from cramlite.model.fault import Fault
from cramlite.model.run.rollout import world_after_run
from cramlite.model.world.thing_boxes import boxes
from cramlite.planning.symbolic.planning_problem import planning_problem
from cramlite.planning.task_goals import Goal
from cramlite.scenario.faults import faulty, read_fault_text
from cramlite.scenario.scenario import Scenario
from cramlite_plugins.shapes.contents import SHARE, where

NOISE = Noise(position=0.001, turn=0.01, force=0.3)
"""Of readings: 1 mm, 0.6 deg in each direction, 0.3 N."""
KINDS = (
    "grasp_lost", "slip", "moved", "removed", "added", "fallen", "drawer_sticks", "physics", "readings", "closes_short", "stopped", "asked",
)  # fmt: skip
SCENES: Mapping[str, tuple[tuple[str, ...], str]] = {
    "product_onto_tray_camera": (("{0} on tray",), "{0} on counter"),
    "each_onto_tray_camera": (("{0} on tray", "{1} on tray"), "{1} on tray"),
    "late_pose_camera": (("{0} on shelf",), "{0} on table"),
    "pouring": (("poured",), ""),
    "two_on_one_shelf": (("red on shelf", "blue on shelf"), "blue on shelf"),
    "small_into_basket": (("sample in basket",), "sample on floor"),
    "into_drawer": (("tin in drawer", "drawer closed"), "tin on floor"),
    "stack_of_four": (("second on first", "third on second", "fourth on third"), "fourth on first"),
    "lid_on_pot": (("lid on pot",), "lid on floor"),
    "bottle_on_rack": (("bottle on rack",), "bottle on floor"),
}
"""Scenario -> the goal that a validator checks, and another one that may be asked for; {0}, {1} are what was seen."""
DRAWERS, TALL = ("into_drawer",), (
    "product_onto_tray_camera", "each_onto_tray_camera", "late_pose_camera", "pouring", "two_on_one_shelf", "into_drawer", "bottle_on_rack",
)  # fmt: skip
"""Scenes with a drawer, and those in which what is handled falls where it is tipped."""
HAND = {"NoGrasp", "GraspLost", "GraspSlip", "GripperDeviation"}
RIGHT: Mapping[str, set[str]] = {
    "grasp_lost": {"GraspLost", "GraspSlip", "ObjectFallen", "ObjectMoved", "NoGrasp"}, "slip": {"GraspSlip", "GraspLost"},
    "removed": {"ObjectMissing"}, "fallen": {"ObjectFallen", "ObjectMoved"},
    "drawer_sticks": {"NoProgress", "StepFailed", "UnexpectedContact"}, "closes_short": HAND, "asked": {"Cancelled"},
}  # fmt: skip
"""Kind of what cannot be mended -> the diagnoses that are right for it."""
SHARED = 60
"""Numbers that share their scenes."""
TUBE = 0.05
"""A joint may be so far from the path of its proof [rad]; guarded motions end where they meet something."""


def unmendable(kind: str, scene: str, phase: str, fault: Fault) -> bool:
    """Whether one arm cannot mend a fault: a thing is gone or its task cancelled, fingers stay wider than their thing, a
    drawer takes more than the arm may pull, or contents spill."""
    spills = scene == "pouring" and (kind == "fallen" or (kind in ("grasp_lost", "slip") and phase == "held"))
    cancelled = kind == "asked" and not fault.goal
    return kind in ("removed", "closes_short") or (kind == "drawer_sticks" and fault.most > 50) or cancelled or spills


class Proven:
    """Scenario with its proven program and the times of its steps."""

    def __init__(self, scene: str, seed: int) -> None:
        self.scene, self.seed, self.engine = scene, seed, Engine()
        self.scenario: Scenario = read_scenario(find_scenario(scene))
        self.setting = self.engine.setting(self.scenario, seed=seed, twins=0)
        found = next(self.engine.resolve(self.scenario, setting=self.setting, seed=seed), None)
        if found is None:
            raise NoSolution(f"{scene}, seed {seed}: nothing was proven.")
        self.solution: Solution = found
        assert found.candidate.code is not None and found.candidate.rollout is not None
        self.code, self.proof = found.candidate.code, found.candidate.rollout
        self.expected: Expectation = expectation(self.proof, self.code.origins)
        self.world = replace(self.setting.real or self.setting.world, faults=())
        self.loose = [t.name for t in self.world.things if not t.furniture]

    def goal(self) -> tuple[str, ...]:
        return tuple(g.format(*self.loose) for g in SCENES[self.scene][0])

    def other(self) -> str:
        return SCENES[self.scene][1].format(*self.loose)

    def moments(self, phase: str) -> list[tuple[int, str]]:
        """Samples of a phase, with the thing that is, or next will be, in the hand; none in which something is poured or looked at."""
        held, found, following = self.expected.held, list[tuple[int, str]](), ""
        for k in range(len(held) - 1, -1, -1):
            following = held[k] or following
            step = self.expected.step(int(self.expected.lines[k])) if self.expected.lines[k] else ""
            quiet = not step or any(w in step for w in ("Pouring/tilt", "Pouring/flow", "Pouring/back", "Looking"))
            wanted = held[k] if phase == "held" else following if not held[k] else ""
            if wanted and not quiet:
                found.append((k, wanted))
        return found[::-1]

    def at(self, sample: int) -> str:
        """A sample as trigger: its step, and how long after that."""
        step = self.expected.step(int(self.expected.lines[sample]))
        first = next(k for k in range(sample + 1) if self.expected.step(int(self.expected.lines[k])) == step)
        return f"line: {step}, after: {self.expected.times[sample] - self.expected.times[first]:.2f} s"

    def stands(self, world: World) -> bool:
        """Whether nothing reaches into something in a world."""
        try:
            self.engine.knowledge.simulator.check(world, self.engine.knowledge.robots_of(world))
        except UserError:
            return False
        return True


_UNPROVEN = set[tuple[str, int]]()
"""Scenes for which no program was proven, with their seeds."""


@lru_cache(maxsize=12)
def proven(scene: str, seed: int) -> Proven:
    return Proven(scene, seed)


class Drawn:
    """Fault of a number: what, where and when, before anything runs."""

    def __init__(self, number: int) -> None:
        self.number, self.kind = number, KINDS[number % len(KINDS)]
        self.rng = np.random.default_rng([number, 2339])
        fitting = [
            s for s in SCENES
            if not (self.kind == "drawer_sticks" and s not in DRAWERS)
            and not (self.kind == "fallen" and s not in TALL)
            and not (self.kind == "asked" and not SCENES[s][1])
        ]  # fmt: skip
        self.proven = self._scene(fitting, 1 + number // SHARED)
        self.scene = self.proven.scene
        self.phase = str(self.rng.choice(["before", "held"]))
        if self.kind in ("moved", "removed", "fallen", "drawer_sticks", "closes_short"):
            self.phase = "before"
        if self.kind in ("grasp_lost", "slip"):
            self.phase = "held"
        moments = self.proven.moments(self.phase)
        if self.kind in ("moved", "removed", "fallen"):  # what is on a joint stays
            moments = [m for m in moments if self.proven.world.thing(m[1]).joint is None]
        self.sample, self.thing = moments[int(self.rng.integers(len(moments)))]
        self.when = self.proven.at(self.sample)
        self.world = self.proven.world
        self.text = getattr(self, f"_{self.kind}")()
        self.fault = read_fault_text(self.text)
        self.mendable = not unmendable(self.kind, self.scene, self.phase, self.fault)
        self.world = faulty(self.world, [self.fault])

    def _scene(self, fitting: list[str], seed: int) -> Proven:
        """A scene in which something can be done at all; others are drawn again."""
        while True:
            scene = str(self.rng.choice(fitting))
            if (scene, seed) not in _UNPROVEN:
                try:
                    return proven(scene, seed)
                except NoSolution:
                    _UNPROVEN.add((scene, seed))

    def _u(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def _grasp_lost(self) -> str:
        return f"grip_lost: {self._u(0.3, 1.0):.2f} s, {self.when}"

    def _slip(self) -> str:
        return f"slip: {self._u(0.0, 0.1):.2f}, lasts: {self._u(0.5, 1.5):.2f} s, {self.when}"

    def _moved(self) -> str:
        thing = self.world.thing(self.thing)
        for _ in range(200):
            far, angle = self._u(0.02, 0.07), self._u(0, 2 * math.pi)
            off = (round(far * math.cos(angle), 3), round(far * math.sin(angle), 3), 0.0)
            there = self.world.moved({self.thing: Pose(off) * thing.pose})
            if self._carried(there.thing(self.thing)) and self.proven.stands(there):
                break
        near = f"near: {self.thing}, within: {self._u(0.12, 0.25):.2f} m"
        return f"moved: {self.thing}, by: [{off[0]}, {off[1]}, 0], {self.rng.choice([near, self.when])}"

    def _carried(self, thing: Thing) -> bool:
        """Whether the middle of a thing is over its support, 20 mm from the edges of that."""
        x, y, _ = thing.pose.position
        low = min(b[0][2] for b in boxes(thing))
        for other in self.world.things:
            for (x0, y0, _), (x1, y1, top) in boxes(other):
                if other.name != thing.name and abs(top - low) < 0.006 and x0 + 0.02 < x < x1 - 0.02 and y0 + 0.02 < y < y1 - 0.02:
                    return True
        return False

    def _removed(self) -> str:
        return f"missing: {self.thing}, {self.when}"

    def _added(self) -> str:
        """An obstacle between a thing and where it is put, or near either, at a place that is free."""
        proof, tool = self.proven.expected.poses, np.asarray(self.proven.expected.poses["effector"])[self.sample, :3]
        begin, end = np.asarray(proof[self.thing])[0, :2], np.asarray(proof[self.thing])[-1, :2]
        for _ in range(500):
            half = (self._u(0.02, 0.035), self._u(0.02, 0.035), self._u(0.04, 0.12))
            x, y = begin + self._u(0, 1) * (end - begin) + self.rng.normal(0.0, 0.08, 2)
            visitor = Thing("visitor", "soma:DesignedArtifact", Pose((float(x), float(y), half[2] + 0.001)), (Geom("box", half),), mass=0.4)
            world = replace(self.world, things=(*self.world.things, visitor))
            clear = math.dist((x, y), tool[:2].tolist()) > 0.15 and math.hypot(x, y) > 0.25
            if clear and self.proven.stands(world):
                break
        self.world = world
        return f"added: visitor, {self.when}"

    def _fallen(self) -> str:
        return f"fallen: {self.thing}, {self.when}"

    def _drawer_sticks(self) -> str:
        drawer = str(self.rng.choice([t.name for t in self.world.things if t.joint is not None]))
        takes = self._u(5, 12) if self.rng.random() < 0.5 else self._u(80, 150)
        return f"sticking: {drawer}, takes: {takes:.0f} N"

    def _physics(self) -> str:
        bias = ", ".join(f"{self._u(-3, 3):.1f} N" for _ in range(3))
        return str(self.rng.choice([
            f"friction: {self._u(0.6, 0.9):.2f}, {self.when}", f"payload: {self._u(0.2, 0.5):.2f} kg, {self.when}", f"sensor: [{bias}]",
        ]))  # fmt: skip

    def _readings(self) -> str:
        return f"readings: {self.rng.choice(['lost', 'frozen'])}, lasts: {self._u(1, 3):.1f} s, {self.when}"

    def _closes_short(self) -> str:
        width = min(float(o) for o, h in zip(self.proven.expected.opening, self.proven.expected.held, strict=True) if h)
        return f"closes_short: {width + self._u(0.006, 0.02):.3f}"

    def _stopped(self) -> str:
        time_ = float(self.proven.expected.times[self.sample])
        connection = f"connection: {time_:.2f} s, lasts: {self._u(0.5, 2):.1f} s"
        return str(self.rng.choice([f"protective_stop: {time_:.2f} s", connection, f"killed: true, {self.when}"]))

    def _asked(self) -> str:
        other = f"goal: [{self.proven.other()}], {self.when}"
        return other if self.rng.random() < 0.5 else f"cancelled: true, {self.when}"


class Watched(GoingOn):
    """Execution whose programs are compared with the paths of their proofs."""

    strayed = 0.0

    def _run(self, attempt: Attempt) -> tuple[RunWatch, Round]:
        watch, done = super()._run(attempt)
        path, lines = watch.expected.joints, done.rollout.lines
        moved = done.rollout.joints[np.flatnonzero(lines > 0)]
        for row in moved[::5]:
            self.strayed = max(self.strayed, float(np.abs(path - row).max(axis=1).min()))
        return watch, done


def run(of: Proven, world: World, number: int) -> tuple[Watched, list[Stretch], str]:
    """Run a proven program in a world, and go on."""
    going, done, why = Watched(of.scenario, of.engine, number, noise=NOISE), list[Stretch](), ""
    going.setting = replace(of.setting, real=None)
    try:
        for stretch in going.stretches(Attempt(of.solution.plan, of.solution.program, of.code, world, of.solution.candidate), 6):
            done.append(stretch)
    except NoSolution as error:
        why = " ".join(str(error).split())[:400]
    return going, done, why


def reached(of: Proven, going: GoingOn, done: Sequence[Stretch], goal: tuple[str, ...]) -> bool:
    """Whether a goal holds in the simulator's own state; what is poured twice, or was spilled before, is not poured."""
    last = done[-1].round
    if goal == ("poured",):
        if any("jug" not in s.round.rollout.grains for s in done):
            return False  # a run that ended before it began, as a stopped arm's does
        early = [where(s.round.rollout, "jug")["jug"] for s in done[:-1]]
        kept = all(int(inside[-1]) == int(inside[0]) for inside in early)
        grains = last.rollout.grains["jug"].shape[1]
        return kept and int(where(last.rollout, "jug")["bowl"][-1]) >= SHARE * grains
    after = world_after_run(last.rollout, last.attempt.world)
    setting = replace(of.setting, look=None, real=None, world=replace(after, robots=(replace(after.robots[0], holds=None),)), relations=())
    try:
        problem = planning_problem(Goal(goal), setting.symbolic(of.engine.knowledge.taxonomy), of.engine.knowledge)
    except UserError:  # what it names is gone
        return False
    return problem.reached


def still(done: Sequence[Stretch]) -> bool:
    """Whether the arm stands at the end."""
    joints = done[-1].round.rollout.joints
    return bool(np.abs(joints[-1] - joints[-2]).max() < 1e-3)


def told(of: Proven, ran: tuple[Watched, list[Stretch], str]) -> dict[str, Any]:
    """Outcome of a run, whatever its fault."""
    going, done, why = ran
    notices = [s.notice for s in done if s.notice]
    peaks = [float(s.round.rollout.contact_force().max()) for s in done]
    limits = [s.round.attempt.program.force_limit for s in done]
    above = [f"{peak:.0f} of {limit:.0f} N" for peak, limit in zip(peaks, limits, strict=True) if peak > limit]
    return {
        "programs": len(done), "diagnoses": [str(n.kind) for n in notices], "said": [str(n)[:160] for n in notices][:3], "why": why,
        "still": still(done), "above": above, "strayed": round(going.strayed, 3), "peak_n": round(max(peaks), 1),
        "thought": [round(s.thought, 2) for s in done if s.decision],
    }  # fmt: skip


def episode(number: int) -> dict[str, Any]:
    """One execution with its fault."""
    began, drawn = time.process_time(), Drawn(number)
    of, ready = drawn.proven, time.process_time()
    ran = run(of, drawn.world, number)
    going, done, why = ran
    notices, happened = [s.notice for s in done if s.notice], [f.time for f in done[0].round.rollout.faults]
    goal, what = drawn.fault.goal or of.goal(), told(of, ran)
    good = reached(of, going, done, goal)
    if not drawn.mendable:
        stopped = bool(why) or (drawn.kind == "asked" and bool(notices))
        safe = stopped and still(done) and not what["above"]
        good = safe and bool(notices) and str(notices[0].kind) in RIGHT[drawn.kind]
    timed = bool(notices and happened) and drawn.kind not in ("closes_short", "drawer_sticks", "physics")
    return {
        "number": number, "kind": drawn.kind, "scene": drawn.scene, "seed": of.seed, "fault": drawn.text, "phase": drawn.phase,
        "mendable": drawn.mendable, "well": good, "triggered": bool(happened) or drawn.fault.from_start,
        "to_notice": round(notices[0].time - happened[0], 3) if timed else None,
        **what, "proof_cpu": round(ready - began, 1), "cpu": round(time.process_time() - ready, 1),
    }  # fmt: skip


def control(scene: str, seed: int) -> dict[str, Any]:
    """The same run without a fault."""
    of, began = proven(scene, seed), time.process_time()
    ran = run(of, of.world, seed)
    return {
        "kind": "none", "scene": scene, "seed": seed, "well": reached(of, ran[0], ran[1], of.goal()), **told(of, ran),
        "cpu": round(time.process_time() - began, 1),
    }  # fmt: skip


def numbers(rows: Sequence[dict[str, Any]]) -> Iterator[Number]:
    """The figure's numbers."""
    faults, controls = [r for r in rows if r["kind"] != "none"], [r for r in rows if r["kind"] == "none"]
    mended, ends = [r for r in faults if r["mendable"]], [r for r in faults if not r["mendable"]]
    yield rate("faults that one arm could mend: goal reached", sum(r["well"] for r in mended), len(mended))
    yield rate("the others: stopped safely with the right diagnosis", sum(r["well"] for r in ends), len(ends))
    yield rate("runs in which a joint left the path of its proof", sum(r["strayed"] > TUBE for r in rows), len(rows))
    yield rate("runs with a force above the program's limit", sum(bool(r["above"]) for r in rows), len(rows))
    yield rate("controls in which something was noticed", sum(bool(r["diagnoses"]) for r in controls), len(controls))
    late, thought = [r["to_notice"] for r in faults if r["to_notice"] is not None], [t for r in faults for t in r["thought"]]
    for what, found in (("from fault to notice, simulated time", late), ("from notice to the next program, CPU time", thought)):
        if found:
            yield value(what, float(np.median(found)), "s", "median")
            yield value(what, float(np.percentile(found, 95)), "s", "95 %")
    for kind in KINDS:
        own = [r for r in faults if r["kind"] == kind]
        if own:
            yield rate(f"as it should be: {kind.replace('_', ' ')}", sum(r["well"] for r in own), len(own))


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--first", type=int, default=0)
    options.add_argument("--count", type=int, default=2 * len(KINDS))
    options.add_argument("--out", type=Path, required=True, help="rows that were run; more are appended")
    add_figure(options)
    asked = options.parse_args()
    wanted = range(asked.first, asked.first + asked.count)
    rows = [json.loads(line) for line in asked.out.read_text().splitlines()] if asked.out.is_file() else []
    for number in wanted:
        if any(r.get("number") == number for r in rows):
            continue
        new = [episode(number)]
        scene = new[0]["scene"], new[0]["seed"]
        if not any(r["kind"] == "none" and (r["scene"], r["seed"]) == scene for r in rows):
            new.append(control(*scene))
        rows += new
        with asked.out.open("a") as file:
            file.writelines(json.dumps(row) + "\n" for row in new)
        print(*map(json.dumps, new), sep="\n", flush=True)
    chosen = [r for r in rows if r["kind"] != "none" and r["number"] in wanted]
    scenes = {(r["scene"], r["seed"]) for r in chosen}
    chosen += [r for r in rows if r["kind"] == "none" and (r["scene"], r["seed"]) in scenes]
    write(asked, numbers(chosen), wanted, sum(r["cpu"] for r in chosen))


if __name__ == "__main__":
    main()
