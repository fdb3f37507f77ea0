"""Preflight: what a program will do on a real arm, by its simulated runs, and the limits to set on arm and controller."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from msgspec import DecodeError, json
from msgspec.structs import replace

from ...base.errors import UserError
from ...base.value import Value
from ...model.program.program import Code, Program
from ...model.program.program_json import is_program_text, read_program, typed_code
from ...model.program.slowed import slowed
from ...model.program.steps import SetGripper, SetPayload, walk
from ...model.robot import Robot
from ...model.run.rollout import Rollout, load_rollout
from ...model.run.run_limits import Reached, reached
from ...model.run.run_peaks import RunPeaks, peaks_of
from ...model.run.verdict import Verdict
from ...model.twins.twin_drawing import Draw
from ...model.world.world import World
from ...plugin.catalogue import Knowledge, pick
from ..proof.intent import Intent, read_intent
from ..proof.judging import JudgedRun, Purpose, judge_text

MARGIN = 1.2
"""Factor from the largest value that a program reaches to the proposed safety limit: a closer limit would stop the arm without need. The
factor is cramlite's own choice."""
OWN: Mapping[str, str] = {"tool_speed": "m/s", "tool_force": "N", "joint_speed": "deg/s", "payload": "kg"}
"""Safety limits that a user may state, each with its unit on the controller's own pages."""


class Flight(Value):
    """Program for a preflight check, with its measured run and all that is known of its proof.

    Args:
        robot: that it is for.
        text: what the robot is given.
        rollout: the nominal run; or the run at a share of the speed, of a dry run.
        program: typed; None where there is only a text.
        intent: what it was made for; None where it is of no run directory.
        verdict: of its proof; None where nothing was proven.
        judged: of the dry run; None where there was none.
        speed: share of its own speed at which it ran.
    """

    robot: Robot
    text: Code
    rollout: Rollout
    program: Program | None = None
    intent: Intent | None = None
    verdict: Verdict | None = None
    judged: JudgedRun | None = None
    speed: float = 1.0

    @property
    def peaks(self) -> RunPeaks | None:
        """Highest measured speeds and forces of the run, and the ranges of its joints; None where nothing moved."""
        return peaks_of(self.rollout)

    @property
    def twins(self) -> tuple[RunPeaks, ...]:
        """Peak values (``RunPeaks``) of the program's successful runs in twins, at full speed; none if this
        is a dry run."""
        runs = self.verdict.twins.twins if self.verdict is not None and self.verdict.twins is not None else ()
        return tuple(t.peaks for t in runs if t.peaks is not None and t.succeeded) if self.speed == 1.0 else ()

    @property
    def draws(self) -> tuple[Draw, ...]:
        """Errors that were drawn for the twins in the program's proof."""
        runs = self.verdict.twins.twins if self.verdict is not None and self.verdict.twins is not None else ()
        return tuple(d for t in runs for d in t.draws)

    def task_at(self, line: int) -> str:
        """Return the task that a line of the text belongs to; "" where that is not known."""
        return self.text.task_of(line) or ""


class Check(Value):
    """Comparison of the largest value that a program reaches of one quantity, such as a joint's speed, with the
    quantity's limit.

    Args:
        name: of the limit.
        unit: of all numbers here.
        reaches: in the run.
        in_twins: the most in any twin in which it succeeded; None where there are none.
        limit: that may not be exceeded, and ``source``, whose limit that is.
        line: of the text where it is reached; 0 where that is nowhere in particular.
        safety: whether a controller has a safety limit of it that is to be set.
    """

    name: str
    unit: str
    reaches: float
    in_twins: float | None
    limit: float
    source: str
    line: int = 0
    safety: bool = True

    @property
    def most(self) -> float:
        """Largest value that the limited quantity reached in the runs of the proof, those in twins included."""
        return max(self.reaches, self.in_twins or 0.0)

    @property
    def passed(self) -> bool:
        """Whether the limited quantity is within its limit in every run, the twins' included."""
        return self.most <= self.limit

    @property
    def setting(self) -> float | None:
        """Safety limit to set on the controller: above the largest value of any run, and at most the
        permitted limit.

        None for a quantity without such a setting.
        """
        if not self.safety:
            return None
        wanted = MARGIN * self.most
        digits = 1 - math.floor(math.log10(wanted)) if wanted > 0 else 0
        rounded: float = math.ceil(wanted * 10.0**digits - 1e-9) / 10.0**digits
        return min(self.limit, rounded)


def flight_of_run(run: Path, knowledge: Knowledge) -> Flight:
    """Read a run directory; its recorded run is measured, and nothing runs again.

    Raises:
        UserError: it holds no program that was proven, or is damaged.
    """
    intent = read_intent(run)
    try:
        verdict = json.decode((run / "verdict.json").read_bytes(), type=Verdict)
    except (OSError, DecodeError) as error:
        raise UserError(f"'{run / 'verdict.json'}' cannot be read: {error}. Run 'cramlite resolve' again.") from error
    robot = pick("robot", knowledge.robots_of(intent.kept.world), intent.program.robot_type)
    if not (run / "rollout.npz").is_file():
        raise UserError(
            f"'{run}' has no recorded run, since programs in its language cannot be run here; so nothing was measured that could be "
            "shown. Give 'program.json', the typed program, with --world."
        )
    _require_unaltered(run, intent)
    rollout = load_rollout(run / "rollout.npz", intent.kept.world)
    return Flight(robot, intent.kept.code, rollout, intent.program, intent, verdict)


def _require_unaltered(run: Path, intent: Intent) -> None:
    """Check that the program file in the run directory, which a robot would be given, holds the text that was proven."""
    path = run / f"program{intent.kept.suffix}"
    try:
        same = path.read_text(encoding="utf-8") == intent.kept.text
    except (OSError, UnicodeDecodeError):
        same = False
    if not same:
        raise UserError(
            f"'{path}' is missing, or differs from the text that was proven and measured. Give that file itself, with "
            f"--world {run}, to measure the text as it is now; or run 'cramlite resolve' again."
        )


def flight_of_text(text: str, world: World, knowledge: Knowledge, seed: int) -> Flight:
    """Simulate a program text in a world, and return it with the recorded run, for a preflight check.

    Raises:
        UserError: it cannot run at all.
    """
    rollout = knowledge.run(text, world, seed)
    typed = read_program(text).program if is_program_text(text) else None
    return Flight(pick("robot", knowledge.robots_of(world), world.robots[0].type), Code("", text, {}, ""), rollout, typed)


def dry_run(flight: Flight, share: float, world: World, knowledge: Knowledge, seed: int) -> Flight:
    """Write a program's text at a share of its speed, run it, and judge the run by the program's plan or goal if known.

    Args:
        share: above 0 and up to 1.

    Raises:
        UserError: there is no typed program that could be written anew.
    """
    if flight.program is None:
        raise UserError(
            f"--speed {share:g}: only a typed program can be written anew at another speed, and this is a text. Give the run "
            f"directory that it came from; or leave --speed out here and set the speed slider of the pendant to {100 * share:g} %."
        )
    program = slowed(flight.program, share)
    code = _written(program, flight, knowledge)
    if flight.intent is None:
        rollout = knowledge.run(code.text, world, seed)
        return replace(flight, text=code, rollout=rollout, program=program, speed=share)
    kept = replace(flight.intent.kept, text=code.text, origins=tuple(sorted(code.origins.items())))
    purpose = Purpose(intent=replace(flight.intent, kept=kept, program=program))
    judged = judge_text(code.text, world, purpose, knowledge, seed)
    return replace(flight, text=code, rollout=judged.rollout, program=program, judged=judged, speed=share)


def _written(program: Program, flight: Flight, knowledge: Knowledge) -> Code:
    """Write a program in the language of the proven text, or as typed code (JSON) if that language cannot be run here."""
    writers = [b for b in knowledge.backends.values() if b.executable]
    own = (b for b in writers if flight.intent is not None and b.name == flight.intent.kept.language)
    writer = next(own, None)
    return writer.emit(program, flight.robot) if writer is not None else typed_code(program)


def checks(flight: Flight, own: Mapping[str, float]) -> Iterator[Check]:
    """Yield a check for each limit: the value that the program reaches, and the limit.

    Args:
        own: limits of the user, by a name of ``OWN``; in place of the robot's and the program's.
    """
    peaks, robot, program = flight.peaks, flight.robot, flight.program
    twins = [_reached(flight, t) for t in flight.twins]
    for k, row in enumerate(_reached(flight, peaks) if peaks is not None else ()):
        most = max((t[k].value for t in twins), default=None)
        yield _check(row, most, own)
    if program is not None:
        allowed = _limit("payload", own, robot.payload, f"of robot '{robot.type}'")
        yield Check("payload", "kg", heaviest(program)[0], None, *allowed, safety=False)


def _reached(flight: Flight, peaks: RunPeaks) -> list[Reached]:
    """Return the values that a run of the program reached, each with the limit that a proof applies."""
    program, robot = flight.program, flight.robot
    force = program.force_limit if program is not None else robot.force_limit
    source = program.force_limit_source if program is not None else f"of robot '{robot.type}'"
    return list(reached(peaks, robot, force, source))


def _check(row: Reached, in_twins: float | None, own: Mapping[str, float]) -> Check:
    """Return the highest value that the program reaches of a limited quantity, with the limit, in the units
    of controllers: degrees for radians."""
    unit, scale = ("deg/s", math.degrees(1.0)) if row.unit == "rad/s" else (row.unit, 1.0)
    allowed = _limit(row.limit, own, scale * row.most, row.source)
    name = " ".join(filter(None, (row.limit.replace("_", " "), row.of)))
    return Check(name, unit, scale * row.value, None if in_twins is None else scale * in_twins, *allowed, row.line)


def _limit(name: str, own: Mapping[str, float], limit: float, source: str) -> tuple[float, str]:
    return (own[name], "yours") if name in own else (limit, source)


def heaviest(program: Program) -> tuple[float, str]:
    """Return the largest payload mass [kg], gripper included, that a program sets on the arm, and the step that sets
    it."""
    loads = [(program.mass, "the empty gripper"), *((s.mass, s.origin) for s in walk(program.steps) if isinstance(s, SetPayload))]
    return max(loads)


def strongest_grip(program: Program) -> float:
    """Return the largest force that the fingers are told to close with [N]; 0 for none."""
    return max((s.force for s in walk(program.steps) if isinstance(s, SetGripper)), default=0.0)


def covered(draws: Iterable[Draw]) -> dict[str, list[tuple[float, float, str]]]:
    """Return for each source of error the largest error drawn in the twins, the largest possible one, and
    the unit."""
    found: dict[tuple[str, str, float], float] = {}
    for draw in draws:
        key = draw.source, draw.unit, round(draw.size, 6)
        found[key] = max(found.get(key, 0.0), abs(draw.value))
    by_source: dict[str, list[tuple[float, float, str]]] = {}
    for (source, unit, size), most in found.items():
        by_source.setdefault(source, []).append((most, size, unit))
    return by_source
