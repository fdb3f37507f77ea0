"""Which tests run when: property tests with fixed seeds but in a fuzz run, and nothing that no run runs."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator

import pytest
from conftest import ROOT
from helpers.properties import DEFAULT, FEWER, MORE, USUAL, examples, load_profile
from hypothesis import given, settings
from hypothesis import strategies as st


@pytest.fixture
def profiles(pytestconfig: pytest.Config) -> Iterator[None]:
    """Afterwards the profile is again what this run asked for."""
    yield
    load_profile(pytestconfig.option.markexpr)


@pytest.mark.usefixtures("profiles")
@pytest.mark.parametrize(
    ("asked", "fixed", "share"),
    [(USUAL, True, 1 / FEWER), ("heavy or fuzz", True, 1), ("", True, 1), ("not fuzz", True, 1), ("fuzz", False, MORE)],
)
def test_seeds_are_fixed_unless_fuzz_is_asked_for(asked: str, fixed: bool, share: float) -> None:
    load_profile(asked)
    assert (settings().derandomize, settings().max_examples) == (fixed, DEFAULT * share)
    assert (examples(8).max_examples, examples(1).max_examples) == (8 * share, max(1, share))
    assert settings().deadline is None, "no test fails because a machine is busy"


@given(st.integers())
def test_a_property_test_is_marked(request: pytest.FixtureRequest, number: int) -> None:
    assert request.node.get_closest_marker("fuzz") is not None


def test_another_is_not(request: pytest.FixtureRequest) -> None:
    assert request.node.get_closest_marker("fuzz") is None


def test_what_the_usual_run_leaves_out_is_run_by_continuous_integration() -> None:
    options = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["pytest"]["ini_options"]
    assert options["addopts"].endswith(f" -m '{USUAL}'") and options["addopts"].count(" -m ") == 1
    runs = (ROOT / ".ci" / "run").read_text().splitlines()
    assert ".venv/bin/python -m pytest -n 3 -m 'heavy or fuzz'" in runs
