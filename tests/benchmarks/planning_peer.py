"""sscbirrt on the problems of planning.py; runs in an environment of its own, which has no cramlite.

    python tests/benchmarks/planning_peer.py PROBLEMS.json ANSWERS.json

Its time is of the complete trajectory: planned, shortened, timed and validated, with a clearance of 5 mm.
Needs sscbirrt and mujoco == 3.14.0, the version that its native collision checker is built for.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any


def solve(problem: dict[str, Any]) -> dict[str, Any]:
    """Milliseconds, duration and joint positions every 10 ms."""
    import mujoco
    from sscbirrt.mujoco import Arm, plan
    from sscbirrt.trajectory import TrajectoryOptions

    model = mujoco.MjModel.from_xml_string(problem["mjcf"])
    data, joints = mujoco.MjData(model), [f"joint{i}" for i in range(len(problem["start"]))]
    arm = Arm(model, joints, "tcp")
    options = TrajectoryOptions(problem["speed"], problem["acceleration"])
    before = time.process_time()
    found = plan(
        model, data, arm, start=problem["start"], goal=problem["goals"], seed=problem["seed"], trajectory=options,
        clearance=problem["clearance"],
    )  # fmt: skip
    spent = time.process_time() - before
    if not found.success or found.trajectory is None:
        return {"ms": 1e3 * spent, "reason": str(found.failure_reason)}
    _, samples = found.trajectory.sample(10_000_000)
    return {"ms": 1e3 * spent, "duration": found.trajectory.duration, "path": samples.tolist(), "backend": found.backend}


if __name__ == "__main__":
    answers = [solve(p) for p in json.loads(Path(sys.argv[1]).read_text())]
    Path(sys.argv[2]).write_text(json.dumps(answers))
