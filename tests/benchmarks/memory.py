"""Memory of a process after it resolved one scenario after another.

    python tests/benchmarks/memory.py SCENARIO... [--plugin FILE] [--expansions 40] [--figure memory --seen yes]

Each scenario has an engine of its own, as the episodes of an experiment have. Scenarios are given as files: those of drawn problems are in
the run directory of their experiment, ``episodes/*/scenario.yaml``.

    python tests/benchmarks/memory.py SCENARIO... --resolves 1000

One engine resolves the scenarios in turn, each time with another seed, and without twins.
"""

from __future__ import annotations

import argparse
import gc
import multiprocessing
import os
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import mujoco
import yaml
from figure import add_figure, value, write
from msgspec.structs import replace

import cramlite.engine.engine as engine_module
from cramlite import Engine, UserError, read_scenario
from cramlite.experiment.figure import Number
from cramlite.plugin.selection import INSTALLED
from cramlite_plugins.simulation.model import compile as _bounds  # noqa: F401  # sets the capacity when it is imported

CAPACITY = 524_288_000
"""Of MuJoCo's cache of meshes and textures by default [bytes]."""
ON_THE_WAY = (1, 10, 30, 100, 300)
"""Resolutions of one engine after which its memory is printed."""
PAGE = os.sysconf("SC_PAGE_SIZE")


def resident() -> float:
    """Resident memory of this process [MB]; Linux."""
    return int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1]) * PAGE / 1e6


def resolved(file: Path, plugin: Path | None, expansions: int) -> str:
    """Resolve a scenario with a small budget, in an engine of its own, and return the outcome."""
    spec = yaml.safe_load(file.read_text(encoding="utf-8"))
    spec["budget"] = {**spec.get("budget", {}), "expansions": expansions, "proofs": 1}
    engine = Engine.with_plugins(replace(INSTALLED, files=() if plugin is None else (plugin,)))
    try:
        scenario = read_scenario(spec)
        found = next(engine.resolve(scenario, setting=engine.setting(scenario, twins=0)), None)
    except UserError as error:
        return str(error)[:70]
    return "no program" if found is None else "proven"


def measured(files: Sequence[Path], plugin: Path | None, expansions: int, kept: bool) -> list[float]:
    """Resolve scenarios in this process, and return its resident memory after each [MB].

    Args:
        kept: the C library keeps what is free, and MuJoCo what it reads, as they do by themselves.
    """
    if kept:
        engine_module.give_back = lambda: None
        mujoco.mj_setCacheCapacity(mujoco.mj_getCache(), CAPACITY)
    after = list[float]()
    for k, file in enumerate(files, 1):
        began = time.process_time()
        said = resolved(file, plugin, expansions)
        gc.collect()
        after.append(resident())
        print(f"{k:3} {file.parent.name}: {after[-1]:.0f} MB, {time.process_time() - began:.1f} s, {said}", flush=True)
    return after


def of_one_engine(files: Sequence[Path], count: int) -> Iterator[Number]:
    """Resolve scenarios in turn in one engine, ``count`` times in all; yield this process's resident memory on the way [MB]."""
    engine, scenarios = Engine(), [read_scenario(file) for file in files]
    for k in range(1, count + 1):
        scenario, seed = scenarios[k % len(scenarios)], k // len(scenarios)
        next(engine.resolve(scenario, setting=engine.setting(scenario, seed=seed, twins=0), seed=seed), None)
        if k in ON_THE_WAY or k == count:
            print(f"{k:4}: {resident():.0f} MB, {time.process_time():.0f} s", flush=True)
            yield value("one engine", resident(), "MB", f"after {k}")


def main() -> None:
    """Resolve all scenarios in two processes, one after the other, or in one engine; print the memory on the way."""
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("scenarios", type=Path, nargs="+")
    options.add_argument("--plugin", type=Path)
    options.add_argument("--expansions", type=int, default=40)
    options.add_argument("--resolves", type=int, metavar="N", help="resolve them in one engine, N times in all")
    add_figure(options)
    asked, numbers = options.parse_args(), list[Number]()
    if asked.resolves:
        write(asked, list(of_one_engine(asked.scenarios, asked.resolves)), f"seeds 0 to {asked.resolves // len(asked.scenarios)}")
        return
    for kept in (True, False):
        what = "memory is kept" if kept else "memory is given back"
        print(what)
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
            after = process.submit(measured, asked.scenarios, asked.plugin, asked.expansions, kept).result()
        marks = sorted({k for k in (1, 5, 10, 20, 40, 80, len(after)) if k <= len(after)})
        numbers += [value(what, after[k - 1], "MB", f"after {k}") for k in marks]
    write(asked, numbers, f"{len(asked.scenarios)} scenarios")


if __name__ == "__main__":
    main()
