"""How an experiment spreads over workers: measured at one and two, simulated beyond.

    python tests/benchmarks/many_machines.py [--trials 100 1000 10000] [--tables FILE] [--measure [--repeats N]]

With ``--measure`` it runs a small experiment (recording, interpretation, a budget that leaves no room for programs) on a Dask cluster
of one and of two workers here, in turn, and measures what the scheduler takes for a task: some 100 s of CPU time, a minute or two
where nothing else runs. It prints each run as it ends. Where something else runs it says so: what two workers gain cannot be told
then. The simulation takes CPU times of whole trials as they were measured (``TRIAL``; from ``tables.json`` of a run: ``--tables
FILE``), puts them on workers, first come first served, and lets the one scheduler handle one task after another.
"""

from __future__ import annotations

import argparse
import heapq
import json
import os
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, median

from figure import add_figure, value, write

sys.path.insert(0, str(Path(__file__).parents[1]))

WORKERS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 400, 800)
START = 4.0
"""CPU time of a worker until its first trial begins [s]: imports, plugins, ontology."""


@dataclass(frozen=True)
class TrialTimes:
    """CPU times of a trial [s]: its own before its twins and after them, and that of each of its twins."""

    before: float
    twin: float
    twins: int
    after: float

    @property
    def whole(self) -> float:
        return self.before + self.twins * self.twin + self.after


TRIAL = TrialTimes(before=2.2, twin=0.9, twins=8, after=3.1)
OVERHEAD = 0.007
"""What the scheduler takes for one task [s]; measured with --measure."""


def simulated(trials: int, workers: int, times: TrialTimes, overhead: float) -> float:
    """Simulated wall time of trials on workers [s]: a trial for each place that becomes free, one after another through the
    scheduler."""
    free = [START] * workers  # when each place is free
    scheduler = 0.0
    for _ in range(trials):
        scheduler += overhead
        heapq.heappush(free, max(heapq.heappop(free), scheduler) + times.whole)
    return max(free)


def from_tables(path: Path) -> TrialTimes:
    """Mean CPU times of the trials of a run that had twins."""
    own, after, twins = [], [], []
    for one in json.loads(path.read_text())["demonstrations"]:
        spent = [one["seconds"], *(c["seconds"] for c in one["results"])]
        total = {k: sum(s.get(k, 0.0) for s in spent) for k in set().union(*spent)}
        late = sum(total.get(k, 0.0) for k in ("execute", "hand over", "judge", "picture"))
        twins.append(total.get("twins", 0.0))
        after.append(late)
        own.append(sum(total.values()) - late - twins[-1])
    return TrialTimes(mean(own), mean(twins) / 8, 8, mean(after))


SMALL = 12
"""Trials of the small experiment: 0.8 s of CPU time each."""
QUIET = 0.5
"""Load of a machine on which nothing else runs, at most."""


def measure(repeats: int) -> None:
    """The small experiment on one and two workers that have begun before, in turn, and the scheduler's time for a task."""
    from helpers.quick_experiment import order, quick_experiment

    from cramlite.experiment.cluster import connected
    from cramlite.experiment.run import run_experiment

    if (load := os.getloadavg()[0]) > QUIET:
        print(f"something else runs here (load {load:.1f} on {os.cpu_count()} cores): these times do not say what two workers gain")
    took: dict[int, list[float]] = {1: [], 2: []}
    with tempfile.TemporaryDirectory() as folder, connected("dask", 1) as one, connected("dask", 2) as two:
        experiment = quick_experiment(Path(folder) / "quick", count=SMALL // 3)
        for n in range(repeats + 1):
            for workers, client in ((1, one), (2, two)):
                where = client.scheduler.address.replace("tcp://", "dask://")
                begin = time.monotonic()
                run_experiment(order(experiment, Path(folder) / f"{n}-{workers}", executor=where), lambda _: None)
                took[workers].append(time.monotonic() - begin)
                print(f"run {n}{' (workers begin)' * (n == 0)}, {workers} workers: {took[workers][-1]:.1f} s", flush=True)
        pool = two.get_executor(pure=False)
        begin = time.monotonic()
        for future in [pool.submit(len, "") for _ in range(500)]:
            future.result()
        task = (time.monotonic() - begin) / 500
    for workers, (_, *warm) in took.items():  # in the first one workers begin
        print(f"{workers} workers: {median(warm):.1f} s for {SMALL} small trials, median of {', '.join(f'{t:.1f}' for t in warm)}")
    print(f"two workers are {median(took[1][1:]) / median(took[2][1:]):.2f} times as fast as one")
    print(f"a task takes the scheduler {task * 1000:.1f} ms (500 empty ones); load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--trials", type=int, nargs="+", default=[100, 1000, 10_000])
    options.add_argument("--tables", type=Path, help="tables.json of a run, for the CPU times of its trials")
    options.add_argument("--overhead", type=float, default=OVERHEAD, help="of the scheduler for one task [s]")
    options.add_argument("--measure", action="store_true")
    options.add_argument("--repeats", type=int, default=3, help="of what is measured, beside a first run in which workers begin")
    add_figure(options)
    asked = options.parse_args()
    if asked.measure:
        measure(asked.repeats)
    times = from_tables(asked.tables) if asked.tables else TRIAL
    print(f"trials of {times.whole:.1f} s CPU time: {times}; {asked.overhead * 1000:.0f} ms of the scheduler for a task")
    print("| workers | " + " | ".join(f"{n} trials" for n in asked.trials) + " |")
    print("|---" * (len(asked.trials) + 1) + "|")
    alone = {n: simulated(n, 1, times, asked.overhead) for n in asked.trials}
    numbers = []
    for workers in WORKERS:
        walls = {n: simulated(n, workers, times, asked.overhead) for n in asked.trials}
        cells = [f"{wall / 60:.1f} min ({alone[n] / wall / workers:.0%})" for n, wall in walls.items()]
        print(f"| {workers} | {' | '.join(cells)} |")
        numbers += [value(f"{n} trials", wall / 60, "min", f"{workers} workers", x=workers) for n, wall in walls.items()]
    write(asked, numbers)


if __name__ == "__main__":
    main()
