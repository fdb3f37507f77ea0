"""``cramlite export``: writes a recorded run in a format that other software opens."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..base.errors import UserError, did_you_mean
from ..base.pulse import working
from ..engine.proof.intent import FILE, PROGRAM, read_intent
from ..engine.recorded_run import record_of
from ..model.program.program import Code, Program
from ..model.program.program_json import read_program
from ..model.run.run_record import RunRecord
from ..planning.heartbeat import Heartbeat
from ..planning.trace import Trace
from ..plugin.catalogue import Knowledge
from ..plugin.exporting import require_absent, require_installed, write_new
from ..plugin.protocols import Exporter
from .arguments import Add, plugin_choice
from .program_input import in_its_world, recorded
from .progress import Progress
from .signals import interruptible


def exporter_named(name: str, knowledge: Knowledge) -> Exporter:
    """Return the export format with a given name.

    Raises:
        UserError: there is none, or it needs what is not installed.
    """
    if name not in knowledge.exporters:
        known = ", ".join(f"{e.name} ({e.about})" for e in knowledge.exporters.values())
        raise UserError(f"There is no format '{name}'; {did_you_mean(name, knowledge.exporters)}valid are: {known}.")
    exporter = knowledge.exporters[name]
    require_installed(exporter)
    return exporter


def run_record(run: Path, world: str | None, knowledge: Knowledge, seed: int = 0) -> RunRecord:
    """Read the recorded run of a run's folder, with its program where the folder has one.

    Raises:
        UserError: as ``cramlite.cli.program_input.recorded``.
    """
    rollout = recorded(run, world, knowledge, seed)
    program, code = program_and_code(run)
    with in_its_world():
        return record_of(rollout, knowledge, run.resolve().name, program, code)


def program_and_code(run: Path) -> tuple[Program | None, Code | None]:
    """Read the typed program of a run's folder, and its text with the origin of each line; None where the folder has none."""
    if (run / FILE).is_file():
        intent = read_intent(run)
        return intent.program, intent.kept.code
    return (read_program((run / PROGRAM).read_text("utf-8")).program if (run / PROGRAM).is_file() else None), None


def _export(arguments: argparse.Namespace) -> int:
    """Write a recorded run in another format, and print where.

    Raises:
        UserError: no such format, its extra is not installed, no run there, or something is where it should be written.
    """
    run, left = arguments.run_dir, "nothing is left of what was written"
    with Progress(quiet=False) as say, interruptible(left) as taken, Heartbeat(Trace(), say, taken.one)():
        knowledge = Knowledge(plugin_choice(arguments).registry())
        exporter = exporter_named(arguments.to, knowledge)
        target = arguments.out or run / f"{exporter.name}{exporter.suffix}"
        require_absent(target)
        with working(f"reading '{run}'"):
            record = run_record(run, arguments.world, knowledge, arguments.seed)
        with working(f"writing {exporter.name}", float(record.rollout.times[-1] - record.rollout.times[0])):
            write_new(exporter, record, target)
    print(target)
    return 0


def add_commands(add: Add) -> None:
    """Add the command ``export``, with its arguments, to the command line."""
    export = add("export", _export)
    export.add_argument(
        "run_dir", type=Path, metavar="RUN", help="a run directory of resolve, or a folder of execute --out"
    )
    export.add_argument("--to", required=True, metavar="FORMAT", help="gif, mp4, csv, mcap, rerun, btcpp, or what a plugin adds")
    export.add_argument("--out", type=Path, help="file or folder to write; default RUN/FORMAT")
    export.add_argument("--world", help="a run directory, its world.json, or a scenario, where RUN holds no world")
    export.add_argument("--seed", type=int, default=0, help="seed of a scenario's world; default 0")
