"""A sample of tests/benchmarks/robot_code.py: mutated programs are refused with a line, or accepted; nothing else."""

from __future__ import annotations

import importlib.util

from conftest import ROOT

SPEC = importlib.util.spec_from_file_location("robot_code", ROOT / "tests" / "benchmarks" / "robot_code.py")


def test_mutated_programs_neither_crash_nor_hang() -> None:
    assert SPEC is not None and SPEC.loader is not None
    bench = importlib.util.module_from_spec(SPEC)
    SPEC.loader.exec_module(bench)
    found = list(bench.judged(500, seed=1))
    outcomes = {outcome for outcome, _, _ in found}
    assert outcomes == {"accepted", "refused with a line"}, [said for outcome, said, _ in found if outcome == "crashed"]
