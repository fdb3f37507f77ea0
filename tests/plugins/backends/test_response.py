"""What an arm is told that is behind what it is told: it stays on its path, and errors of it vanish, whatever it pulls with."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm

from cramlite_plugins.backends.stream.response import SAMPLES, Response

PERIOD = 0.05


def spring(inertia: float, pull: float) -> tuple[np.ndarray, np.ndarray]:
    """Place and speed after a period (2, 2), and what an action adds (2,), of a critically damped spring that pulls so many times as hard
    as it should."""
    w = 1.0 / math.sqrt(inertia)
    whole = expm(PERIOD * np.array([[0.0, 1.0, 0.0], [-pull * w**2, -2 * pull * w, pull * w**2], [0.0, 0.0, 0.0]]))
    return whole[:2, :2], whole[:2, 2]


def errors(inertia: float, pull: float, correct: bool, periods: int = 30) -> np.ndarray:
    """How far the spring is from where it should rest, period by period; 1 at first."""
    response, (free, led), state = Response(0.0, inertia, PERIOD, 1), spring(inertia, pull), np.array([1.0, 0.0])
    found = []
    for _ in range(periods):
        off = np.array([-state[0], 0.0, 0.0, 0.0, 0.0, 0.0])
        found.append(abs(state[0]))
        told = response.correction(off)[0] if correct else 0.0
        response.passed(np.zeros(1), off)
        state = free @ state + led * told
    return np.array(found)


@pytest.mark.parametrize("pull", [0.2, 0.5, 1.0, 1.5, 2.0])
def test_errors_vanish_sooner_than_by_themselves(pull: float) -> None:
    corrected, alone = errors(1 / 150, pull, True), errors(1 / 150, pull, False)
    assert corrected[-1] < 1e-2 and corrected.sum() < alone.sum()


def test_a_spring_that_is_sampled_too_coarsely_is_left_alone() -> None:
    fine, coarse = ((SAMPLES * PERIOD / 2) ** 2 * share for share in (1.01, 0.99))
    assert Response(0.1, fine, PERIOD, 1).stiffer > 0
    assert Response(0.1, coarse, PERIOD, 1).stiffer == Response(0.1, 0.0, PERIOD, 1).stiffer == 0.0
    assert not Response(0.1, coarse, PERIOD, 1).correction(np.ones(6)).any()


def furthest(inertia: float) -> float:
    """How far a spring of 150 rad2/s2 is off a ramp that speeds up and brakes with 2 rad/s2, if so much inertia is known of [rad]."""
    response, (free, led) = Response(2 / math.sqrt(150) - PERIOD / 2, inertia, PERIOD, 1), spring(1 / 150, 1.0)
    state, way, rate, off = np.zeros(2), 0.0, 0.0, 0.0
    for k in range(40):
        rate += 2.0 * PERIOD * (1 if k < 8 else -1 if 16 <= k < 24 else 0)
        way += rate * PERIOD
        told = way + response.lead(np.array([rate]), free=True)[0]
        response.passed(np.array([rate]), np.zeros(6))
        state = free @ state + led * told
        off = max(off, abs(way - state[0]))
    return off


def test_an_arm_with_inertia_brakes_in_time() -> None:
    assert furthest(1 / 150) < 0.5 * furthest(0.0)


def test_force_mode_is_led_by_the_lag_alone() -> None:
    response = Response(0.1, 1 / 150, PERIOD, 1)
    assert response.lead(np.array([0.5]), free=False) == pytest.approx(0.05)
    assert response.lead(np.array([0.5]), free=True) > 0.05
