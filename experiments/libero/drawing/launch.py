"""Start the benchmark's script with a suite ``drawn``, whose tasks are the problems of the folder that this file was copied into.

It runs in the benchmark's environment, in place of its Python: ``launch.py SCRIPT``.
"""

from __future__ import annotations

import hashlib
import json
import os
import runpy
import sys
from pathlib import Path
from typing import Any

os.environ.setdefault("MUJOCO_GL", "egl")
PROBLEMS = Path(__file__).resolve().parents[1]
SUITE = "drawn"


class Drawn:
    """Benchmark suite in LIBERO's interface: each seed is a task, with one initial state."""

    def get_num_tasks(self) -> int:
        """Return the number of tasks in LIBERO's interface: one more than the last seed."""
        return 1 + max((int(p.parent.name) for p in PROBLEMS.glob("*/problem.json")), default=-1)

    def get_task(self, seed: int) -> Any:
        """Return a task: its problem file, and its name with a digest of its files."""
        from libero.libero.benchmark import Task

        folder = self._folder(seed)
        facts = json.loads((folder / "problem.json").read_text(encoding="utf-8"))
        text, state = folder / "problem.bddl", folder / "state.txt"
        digest = hashlib.blake2b(text.read_bytes() + state.read_bytes(), digest_size=4).hexdigest()
        if digest != facts["digest"]:
            raise ValueError(f"the files of problem {seed} were altered since the problem was drawn")
        name = f"{digest} {facts['kind']}: {facts['words']}"
        return Task(name, facts["words"], "Libero", "", str(text), "")

    def get_task_init_states(self, seed: int) -> Any:
        """Return the initial states of the problem that a seed names: a list of one, since each problem has only one."""
        import numpy as np

        return [np.loadtxt(self._folder(seed) / "state.txt")]

    def _folder(self, seed: int) -> Path:
        folder = PROBLEMS / f"{seed:04d}"
        if not (folder / "problem.json").exists():
            raise ValueError(f"there is no problem {seed} in {PROBLEMS}")
        return folder


def main() -> None:
    """Register the suite of drawn problems, and run the benchmark's script that the command line names."""
    from libero.libero import benchmark

    benchmark.BENCHMARK_MAPPING[SUITE] = Drawn
    sys.argv = sys.argv[1:]
    runpy.run_path(sys.argv[0], run_name="__main__")


if __name__ == "__main__":
    main()
