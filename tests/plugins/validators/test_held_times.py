"""A refusal by a rule says at which times of the run its condition did hold."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT, TASKS
from helpers.interpretation_samples import SHOP, episode, hanger_episode, state
from msgspec.structs import replace

from cramlite import Budget, Engine, Trace, read_scenario
from cramlite.interpretation.rules import load_rules
from cramlite.model import Value
from cramlite.plugin import Clause, Phase, Timeline
from cramlite_plugins.validators.held_times import held_times, said_times, said_values

KNOWN = Engine().knowledge


def _times(phase: str, condition: str, where: Timeline, folder: Path, bound: Mapping[str, str] | None = None) -> str:
    return said_times(held_times(_clause(phase, condition, folder), [{"Patient": "product", **(bound or {})}], where))


def _clause(phase: str, condition: str, folder: Path) -> Clause:
    file = folder / "one.yaml"
    bound = "pre:\n  - grasps(_, Patient)\n  - touches(Hanger, Patient)\n"
    head = "task: soma:Holding\nroles: {Patient: soma:Patient}\nsource: a test\n"
    file.write_text(f"{head}{phase}:\n  - {condition}\n{bound}explain: '{{Patient}}'\n")
    (rule,) = load_rules([file], KNOWN.predicates, KNOWN.taxonomy)
    return next(c for c in rule.clauses if c.text == condition)


def _timeline() -> Timeline:
    return Timeline(hanger_episode(), KNOWN.taxonomy)


@pytest.mark.parametrize(
    ("phase", "condition", "says"),
    [
        ("run", "grasps(Gripper, Patient)", "it held from 2.80 to 6.00 s"),
        ("post", "grasps(Gripper, Patient)", "it held from 2.80 to 5.90 s"),  # the last moment looked at is before the end
        ("run", "touches(Patient, Nobody)", ""),
        ("run", "supports(_, Patient)", "it held from 0.00 to 3.50 s, from 6.40 to 8.00 s"),
        ("run", "grasps(Nobody, Patient)", ""),
        ("run", "isa(Patient, vrps:Peg)", ""),
    ],
)
def test_times(phase: str, condition: str, says: str, tmp_path: Path) -> None:
    assert _times(phase, condition, _timeline(), tmp_path, {"Nobody": "nobody"}) == says


def test_many_times_are_counted(tmp_path: Path) -> None:
    touches = [state("contact", "hand", "product", 0.5 * k, 0.5 * k + 0.2) for k in range(5)]
    where = Timeline(episode(SHOP, [*touches, state("contact", "hanger", "basket", 0.0, 4.0)]), KNOWN.taxonomy)
    says = _times("run", "touches(Hand, Patient)", where, tmp_path, {"Hand": "hand"})
    assert says == "it held from 0.00 to 0.20 s, from 0.50 to 0.70 s, from 1.00 to 1.20 s and 2 times more"
    assert said_times([(1.0, 1.0)]) == "it held at 1.00 s"


class Between(Value):
    """Condition that holds of what begins in one of some spans of time [s]."""

    spans: tuple[tuple[float, float], ...]

    def solve(self, phase: Phase, binding: Any) -> Iterator[Any]:
        """Give the binding where it holds."""
        if any(a <= phase.start <= b for a, b in self.spans):
            yield binding


@pytest.mark.parametrize(
    ("spans", "says"),
    [
        (((0.25, 0.45),), "it held from 0.30 to 0.40 s"),
        (((7.25, 7.45),), "it held from 7.30 to 7.40 s"),
        (((0.25, 0.45), (7.25, 7.65)), "it held from 0.30 to 0.40 s, from 7.30 to 7.60 s"),
    ],
)
def test_moments_are_looked_at_from_the_beginning_to_the_end(spans: tuple[tuple[float, float], ...], says: str, tmp_path: Path) -> None:
    clause = replace(_clause("post", "grasps(Gripper, Patient)", tmp_path), condition=Between(spans))  # type: ignore[arg-type]
    where = _timeline()
    assert where.cuts[1] > 0.5 and where.cuts[-2] < 7.2  # nothing changes at these times
    assert said_times(held_times(clause, [{}], where)) == says


@pytest.mark.parametrize(
    ("spans", "says"),
    [
        ([(1.0, 1.0049)], "it held at 1.00 s"),
        ([(0.0, 0.005)], "it held from 0.00 to 0.01 s"),
        ([(1.0, 2.0)] * 3, "it held from 1.00 to 2.00 s, from 1.00 to 2.00 s, from 1.00 to 2.00 s"),
        ([(1.0, 1.0)] * 4, "it held at 1.00 s, at 1.00 s, at 1.00 s and once more"),
        ([(1.0, 1.0)] * 5, "it held at 1.00 s, at 1.00 s, at 1.00 s and 2 times more"),
        ([], ""),
    ],
)
def test_of_many_the_first_three_are_said(spans: list[tuple[float, float]], says: str) -> None:
    assert said_times(spans) == says


@pytest.mark.parametrize(
    ("condition", "says"), [("constrained_dof(Hanger, Patient) < 1", r": it is \d"), ("grasps(Gripper, Patient)", "$")]
)
def test_a_comparison_says_what_the_value_is(condition: str, says: str, tmp_path: Path) -> None:
    where, bound = _timeline(), {"Patient": "product", "Hanger": "hanger"}
    clause = _clause("run", condition, tmp_path)
    assert re.match(says, said_values(clause, [bound], where.instant(1.0)))


@pytest.mark.heavy
def test_a_refused_run_says_when_it_held(tmp_path: Path) -> None:
    """Grasping is asked to hold the thing all through, which it does only from its end on."""
    for rule in (ROOT / "task_rules").glob("*.yaml"):
        text = rule.read_text()
        if rule.name == "grasping.yaml":
            text = text.replace("post:\n", "run:\n  - grasps(Gripper, Patient)\npost:\n")
        (tmp_path / rule.name).write_text(text)
    trace, budget = Trace(), Budget(proofs=1)
    assert list(Engine(rules=tmp_path).resolve(read_scenario(TASKS), budget=budget, trace=trace)) == []
    ((said, remedy),) = [(e.reason, e.remedy) for e in trace.entries if e.designator == "proof" and e.outcome == "failed"]
    found = re.search(
        r"during 1\.Grasping 'grasps\(Gripper, Patient\)' does not hold \(Patient = tea\): "
        r"it held from ([\d.]+) to ([\d.]+) s; 1\.Grasping ran from ([\d.]+) to ([\d.]+) s",
        said,
    )
    assert found, said
    held, let_go, begun, ended = map(float, found.groups())
    assert begun < held <= ended + 0.2 < let_go
    line = 1 + (tmp_path / "grasping.yaml").read_text().splitlines().index("run:") + 1
    assert remedy is not None and f"grasping.yaml:{line} does not hold during soma:Grasping: change what the task does" in remedy.says
