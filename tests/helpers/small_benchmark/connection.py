"""The small benchmark as cramlite sees it: LIBERO's connection, with another process behind it.

``SMALL_BENCHMARK`` holds words for that process: what shall go wrong, and when.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from cramlite.experiment.benchmark.protocol import module_of
from cramlite_plugins.benchmarks.benchmark_process import BenchmarkProcess

HERE = Path(__file__).parent
PATIENCE = 20.0
"""Longest time in which the benchmark answers before it counts as hanging [s]; for its first answer it has six times as long."""
LIBERO = module_of(HERE.parents[2] / "experiments" / "libero" / "connection.py")


class SmallBenchmark(LIBERO.Libero):  # type: ignore[misc,name-defined]
    """LIBERO's connection to the small benchmark."""

    def __init__(self) -> None:
        command = [sys.executable, str(HERE / "simulator.py"), *os.environ.get("SMALL_BENCHMARK", "").split()]
        BenchmarkProcess.__init__(self, command, "here", "libero_panda", 7, patience=float(os.environ.get("SMALL_PATIENCE", PATIENCE)))


def connect(environment: Path | None) -> SmallBenchmark:
    """Return the benchmark; it needs no environment."""
    del environment
    return SmallBenchmark()
