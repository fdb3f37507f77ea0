"""How many runs a proof takes, how many of them must succeed, and when the others can change nothing any more."""

from __future__ import annotations

from typing import Any

import pytest

from cramlite import UserError
from cramlite.model import ProofDoubts


@pytest.mark.parametrize(
    ("twins", "at_least", "needed"),
    [
        (8, 0.85, 8), (8, 1.0, 9), (8, 0.0, 0), (9, 0.85, 9), (0, 0.85, 1), (19, 0.85, 17), (19, 0.8501, 18), (8, 8 / 9, 8),
        (9, 0.1 + 0.2, 3), (1000, 1.0, 1001),
    ],
)  # fmt: skip
def test_a_share_of_all_runs_is_needed_the_nominal_one_counted(twins: int, at_least: float, needed: int) -> None:
    """0.1 + 0.2 is a little more than 0.3 in binary fractions: 3 of 10 are that share."""
    doubts = ProofDoubts(twins, at_least)
    assert (doubts.runs, doubts.needed) == (twins + 1, needed)


@pytest.mark.parametrize(
    ("succeeded", "ran", "decided"),
    [(1, 1, False), (7, 8, False), (8, 8, True), (7, 9, True), (1, 2, False), (1, 3, True), (6, 7, False), (6, 8, True), (9, 9, True)],
)
def test_eight_of_nine_are_decided_by_the_eighth_success_or_the_second_failure(succeeded: int, ran: int, decided: bool) -> None:
    assert ProofDoubts().decided(succeeded, ran) is decided


def test_the_default_is_eight_twins_and_85_percent() -> None:
    assert (ProofDoubts().twins, ProofDoubts().at_least) == (8, 0.85)


@pytest.mark.parametrize("given", [{"twins": 0}, {"twins": 1000}, {"at_least": 0}, {"at_least": 1}, {"at_least": 1.0}])
def test_doubts_at_the_borders_are_doubts(given: dict[str, Any]) -> None:
    assert ProofDoubts(**given).runs >= 1


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"twins": -1}, "The number of twins is -1; it is a whole number in 0 .. 1000, 0 for none."),
        ({"twins": 1001}, "The number of twins is 1001"),
        ({"twins": 2.0}, "The number of twins is 2.0"),
        ({"twins": True}, "The number of twins is True"),
        ({"at_least": -0.001}, "at_least is -0.001; it is the share of runs that must succeed, in 0 .. 1."),
        ({"at_least": 1.001}, "at_least is 1.001"),
        ({"at_least": float("nan")}, "at_least is nan"),
    ],
)
def test_doubts_beyond_them_are_refused(given: dict[str, Any], said: str) -> None:
    with pytest.raises(UserError) as caught:
        ProofDoubts(**given)
    assert str(caught.value).startswith(said)
