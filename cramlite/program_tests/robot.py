"""Robot of a test: it runs programs in a world, nominally and in twins."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any

from ..base.errors import UserError
from ..base.resources import find_scenario
from ..base.seeds import derive_seed
from ..base.value import Value
from ..model.fault import Fault
from ..model.twins.error_model import ErrorModel
from ..model.world.world import World
from ..plugin.catalogue import Knowledge, pick
from ..plugin.selection import PluginChoice
from ..scenario.faults import faulty, read_fault
from ..scenario.scenario import Scenario, read_scenario
from ..scenario.twin import Twin, draw_twin
from ..scenario.worlds import build_world, read_world, real_world
from .program_run import ProgramRun, Way


class TestPlace(Value):
    """Name and folders of a pytest test that runs robot programs.

    Args:
        name: of the test, as pytest has it.
        folder: of its file; paths of programs, worlds and snapshots are relative to it.
        pages: folder for pages about failures.
        accept: whether snapshots are written anew.
        faults: of all runs of the test.
    """

    __test__ = False

    name: str
    folder: Path
    pages: Path
    accept: bool = False
    faults: tuple[Fault, ...] = ()


class Cell(Value):
    """World in which a program runs, with the errors of its twins.

    Args:
        relations: that a scenario states, as ("hangs_on", thing, hanger).
        errors: of its twins.
    """

    world: World
    relations: tuple[tuple[str, str, str], ...] = ()
    errors: ErrorModel = ErrorModel()


class ProgramRobot:
    """Robot that runs programs under test: the fixture ``cramlite_robot``."""

    def __init__(self, place: TestPlace, world: str | None = None) -> None:
        self.place, self.world = place, world
        self._count = 0

    def run(
        self,
        program: str | Path,
        *,
        world: str | Path | None = None,
        twins: int = 0,
        seed: int = 0,
        faults: Iterable[Mapping[str, Any]] = (),
        plugins: tuple[Path, ...] = (),
    ) -> ProgramRun:
        """Run a program's text in a world, and in twins of it.

        Whatever the program does, this returns: what should have happened is asked of the run.

        Args:
            program: a file, relative to the test's; URScript, a typed program as JSON, or a client of ur_rtde. A text with line
                breaks is the program itself.
            world: a scenario's file or name, a run directory, or its ``world.json``; what the fixture ``cramlite_world`` says by
                default. Its first robot runs the program.
            twins: further runs, in worlds that are off by the declared errors: poses, sizes, masses, friction, sensors, latency.
            seed: of the scenario's world, the sensors' noise and the twins.
            faults: what goes wrong in each run, beside those of the test's marks: {"missing": "part"}, {"moved": "part",
                "by": ["30 mm", 0, 0]}, {"payload": "0.8 kg"}, {"tool": [0, 0, "10 mm"]}, {"sensor": ["5 N", 0, 0]},
                {"protective_stop": "2 s"}, {"connection": "2 s", "lasts": "1 s"}.
            plugins: files with plugins that the world needs.

        Raises:
            UserError: the program cannot run at all, or a file cannot be used; with file, line, and what would be right.
        """
        name, text = self._program(program)
        knowledge = knowledge_of(plugins)
        cell = self._cell(world, knowledge, seed, name)
        wrong = (*self.place.faults, *(read_fault(f, f"{name}, fault {f}") for f in faults))
        ways = tuple(self._ways(name, text, cell, knowledge, twins, seed, wrong))
        self._count += 1
        return ProgramRun(name, text, ways, knowledge, self.place.folder, self._page(), self.place.accept)

    def _program(self, program: str | Path) -> tuple[str, str]:
        if isinstance(program, str) and "\n" in program:
            return "program", program
        path = self.place.folder / program
        try:
            return str(program), path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise UserError(f"The program '{path}' cannot be read: {error}.") from None

    def _cell(self, world: str | Path | None, knowledge: Knowledge, seed: int, name: str) -> Cell:
        chosen = world or self.world
        if chosen is None:
            raise UserError(
                f"Say where '{name}' runs: run(..., world='cell.yaml'), or a fixture 'cramlite_world' that returns 'cell.yaml'."
            )
        near = self.place.folder / chosen
        cell = read_cell(str(near) if near.exists() else str(chosen), knowledge, seed)
        if not cell.world.robots:
            raise UserError(f"The world '{chosen}' has no robot, so nothing can run '{name}'.")
        return cell

    def _ways(
        self, name: str, text: str, cell: Cell, knowledge: Knowledge, twins: int, seed: int, faults: tuple[Fault, ...]
    ) -> Iterator[Way]:
        robots = knowledge.robots_of(cell.world)
        mount = cell.world.robots[0]
        arm = pick("robot", robots, mount.type)
        for number in range(twins + 1):
            twin = Twin(cell.world, ())
            if number:
                twin = draw_twin(
                    cell.world, cell.relations, arm, cell.errors, derive_seed(seed, (), f"test twin {number}")
                )
            try:
                rollout = knowledge.simulator.execute(
                    text, faulty(twin.world, faults), robots, mount=mount.name, seed=seed + number
                )
            except UserError as error:
                raise UserError(f"{name}: {error}") from None
            yield Way(f"twin {number} of {twins}" if number else "the run", rollout, twin.draws)

    def _page(self) -> Path:
        kept = "".join(c if c.isalnum() or c in "-_." else "_" for c in PurePosixPath(self.place.name).name)
        return self.place.pages / f"{kept}{f'-{self._count}' if self._count > 1 else ''}.html"


@lru_cache(maxsize=4)
def knowledge_of(plugins: tuple[Path, ...]) -> Knowledge:
    """Return the knowledge of the installed plugins and some plugin files; it is collected once in a
    process."""
    return Knowledge(PluginChoice(plugins).registry())


def read_cell(name: str, knowledge: Knowledge, seed: int) -> Cell:
    """Read a world by name; that of a scenario comes with the errors that the scenario declares.

    Raises:
        UserError: it cannot be read.
    """
    scenario = _scenario(name)
    if scenario is None:
        return Cell(read_world(name, knowledge, seed))
    spec = scenario.spec
    built, relations = build_world(scenario, spec.things, spec.vary, knowledge, seed)
    world = real_world(scenario, built, relations, seed)
    kind = world.robots[0].type if world.robots else ""
    robot = knowledge.robots_of(world).get(kind)
    errors = spec.proof.errors.errors(ErrorModel(), robot.sensor_errors) if robot else ErrorModel()
    return Cell(world, relations, errors)


def _scenario(name: str) -> Scenario | None:
    """Return the scenario with a name; None if the name is that of a run directory or of a world's file."""
    path = Path(name)
    if path.is_dir() or path.suffix == ".json":
        return None
    return read_scenario(find_scenario(name))
