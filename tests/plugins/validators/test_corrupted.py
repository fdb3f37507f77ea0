"""Forty programs of the corpus in ``tests/benchmarks/corruption``: thirty that do harm are refused, ten that do none pass."""

from __future__ import annotations

from pathlib import Path

import pytest
from benchmarks.corruption.bases import BASES, Ready, ready
from benchmarks.corruption.cases import FIXED, OPEN, Case, fixed
from benchmarks.corruption.judging import answer
from benchmarks.corruption.rule import Seen
from benchmarks.corruption.typed import unwatched

from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.selection import INSTALLED

pytestmark = pytest.mark.heavy

CASES = fixed()


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder in which the bases are resolved."""
    return tmp_path_factory.mktemp("corrupted")


@pytest.fixture(scope="module")
def readies(work: Path) -> dict[str, Ready]:
    """The bases of the forty, resolved."""
    knowledge = Knowledge(INSTALLED.registry())
    return {b.name: ready(b, work, knowledge) for b in BASES if b.name in {c.base for c in CASES}}


def test_there_are_forty_of_all_classes() -> None:
    groups = [c.rule.group for c in CASES]
    assert len(CASES) == len(FIXED) == 40
    assert groups.count("H") == 10
    assert set(groups) == {"A", "B", "C", "D", "E", "N", "H"}


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_what_does_harm_is_refused_and_what_does_none_passes(case: Case, work: Path, readies: dict[str, Ready]) -> None:
    told = answer(case, work)
    assert told.counts, f"the edit does not do what its rule means: {told.oracle or told.halted or told.error}"
    assert told.passed == (case.rule.group == "H"), told.oracle or told.reasons
    assert told.passed or told.right, told.reasons


@pytest.mark.parametrize("name", sorted({c.base for c in CASES}))
def test_no_oracle_sees_harm_in_a_base_as_it_is(name: str, readies: dict[str, Ready]) -> None:
    """Whether a safeguard is lost is seen in the text, and not in a run."""
    base = readies[name]
    said = {r.name: r.oracle(Seen(base, base.run)) for r in OPEN if r.takes(base.base) and r.oracle is not unwatched}
    assert not {rule: what for rule, what in said.items() if what}
