"""Outcomes of executions whose executor, program or controller is killed by SIGKILL, at moments spread over the run.

    python tests/benchmarks/killed.py [--moments 10]

*Program*: that of ur_rtde, which drives and monitors a virtual controller from outside; the arm must stand within the watchdog's time and
braking, by the controller's clock. *Controller*: the program must end by itself, with the reason. *Executor*: ``execute --replan`` with a
fault; whatever it has recorded must be readable, and a second start to the same folder go on or say why not.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from figure import add_figure, rate, value, write

sys.path.insert(0, str(Path(__file__).parents[1]))
from helpers.killed import (
    BRAKING,
    COMMAND,
    ENDS,
    SILENT,
    WATCHDOG,
    client_of,
    controlled,
    killed_client,
    killed_controller,
    killed_executor,
    lost,
    moved_for,
)

from cramlite.experiment.figure import Number

SCENARIO = "place_on_shelf"
FAULT = "moved: block, by: [0, 60 mm, 0], near: block, within: 0.18 m"


def moments(whole: float, number: int) -> list[float]:
    """Moments in the middle of equal parts of a time."""
    return [whole * (k + 0.5) / number for k in range(number)]


def of_program(run: Path, folder: Path, number: int) -> list[Number]:
    """Numbers of killed programs and controllers."""
    client = client_of(run / "program.json", folder)
    with controlled(client, SCENARIO, folder) as (_, driver, receive):
        whole = moved_for(driver, receive, 1e9)
    print(f"the program's arm is under way for {whole:.1f} s")
    halts, ends = list[float](), list[tuple[float, int, str]]()
    for moment in moments(whole, number):
        if (halted := killed_client(client, SCENARIO, folder, moment)) is not None:
            halts.append(halted)
            print(f"program killed at {moment:.1f} s: the arm stands after {halted:.2f} s", flush=True)
        if (ended := killed_controller(client, SCENARIO, folder, moment)) is not None:
            ends.append(ended)
            print(f"controller killed at {moment:.1f} s: the program ends after {ended[0]:.1f} s with {ended[1]}: {ended[2]}", flush=True)
    in_time = sum(h <= WATCHDOG + BRAKING for h in halts)
    told = sum(t <= SILENT + ENDS and code == 1 and said.startswith("cramlite abort: ") for t, code, said in ends)
    return [
        rate("program killed: the arm stands within the watchdog's time and braking", in_time, len(halts)),
        value("until it stands, controller's clock", median(halts), "s", part="median"),
        value("until it stands, controller's clock", max(halts), "s", part="longest"),
        rate("controller killed: the program ends by itself and says why", told, len(ends)),
        value("until it ends", max(t for t, _, _ in ends), "s", part="longest"),
    ]  # fmt: skip


def of_executor(run: Path, folder: Path, number: int) -> list[Number]:
    """Numbers of killed executors."""
    command = ["execute", run / "program.script", "--world", SCENARIO, "--replan", SCENARIO, "--fault", FAULT]
    began = time.monotonic()
    assert not killed_executor(command, folder / "whole", 600.0) and not lost(folder / "whole")
    whole, kept, told, killed = time.monotonic() - began, 0, 0, 0
    for k, moment in enumerate(moments(whole, number)):
        out = folder / f"killed_{k}"
        if not killed_executor(command, out, moment):
            continue
        killed += 1
        broken = lost(out)
        kept += not broken
        again = subprocess.run([*COMMAND, *map(str, command), "--out", str(out)], capture_output=True, text=True, check=False)
        told += not again.returncode or "is not an empty folder; nothing was run" in again.stderr
        said = f"{broken or 'nothing is lost'}; second start {again.returncode}"
        print(f"executor killed at {moment:.1f} s of {whole:.1f} s: {said}", flush=True)
    return [
        rate("executor killed: nothing that was recorded is lost", kept, killed),
        rate("executor killed: a second start goes on, or says why not", told, killed),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--moments", type=int, default=10)
    add_figure(parser)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run = folder / "run"
        resolve = [*COMMAND, "resolve", SCENARIO, "--twins", "0", "--no-report", "--out", str(run)]
        subprocess.run(resolve, check=True, stdout=subprocess.DEVNULL)
        numbers = [*of_program(run, folder, options.moments), *of_executor(run, folder, options.moments)]
    for number in numbers:
        print(number)
    write(options, numbers, seeds=f"{options.moments} moments each")


if __name__ == "__main__":
    main()
