"""Contacts that chatter: what the wrist felt decides whether the hand let go."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.episode_builders import rollout
from msgspec.structs import replace

from cramlite_plugins.episodes.detection.touches import pressed_on

HAND, PLATE, POST = "hand", "plate", "post"


def filled(force: float, gap: int = 20, *, other: bool = False) -> bool:
    """Whether a gap of so many samples at 50 Hz counts as contact, with a force [N] at the wrist all through."""
    run = rollout()
    n = len(run.times)
    wrench = np.tile([0.0, 0.0, -force, 0.0, 0.0, 0.0], (n, 1))
    run = replace(run, effector=HAND, times=np.arange(n) / 50, wrench=wrench)
    plate, post = np.ones(n, dtype=bool), np.zeros(n, dtype=bool)
    plate[10 : 10 + gap] = False
    post[15] = other
    return bool(pressed_on({(HAND, PLATE): plate, (HAND, POST): post}, run)[HAND, PLATE].all())


def test_a_hand_that_presses_on_all_the_while_has_not_let_go() -> None:
    assert filled(12.0)


@pytest.mark.parametrize(
    ("why", "force", "gap", "other"),
    [("nothing is felt", 0.5, 20, False), ("too long", 12.0, 30, False), ("something else presses", 12.0, 20, True)],
)
def test_a_gap_is_one_where(why: str, force: float, gap: int, other: bool) -> None:
    assert not filled(force, gap, other=other), why


def test_only_the_effector_is_felt() -> None:
    run = rollout()
    on = np.ones(len(run.times), dtype=bool)
    on[10:30] = False
    assert not pressed_on({(POST, PLATE): on}, run)[POST, PLATE].all()
