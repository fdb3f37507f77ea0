"""Kinematics of many joint positions at once: what each alone has."""

from __future__ import annotations

import numpy as np
import pytest

from cramlite_plugins.kinematics import kinematics as k
from cramlite_plugins.kinematics.many import conditionings, refined
from cramlite_plugins.robots.fr3 import FR3
from cramlite_plugins.robots.ur5e import UR5E


@pytest.mark.parametrize("robot", [UR5E, FR3], ids=lambda r: r.type)
def test_they_are_those_of_each_alone(robot: k.Robot) -> None:
    many = np.array(robot.home) + np.random.default_rng(0).uniform(-0.2, 0.2, (20, len(robot.home)))
    goals = np.array([k.forward(robot, q).matrix for q in many])
    near = many + 0.01
    alone = [k.refine(robot, k.forward(robot, q), start, steps=4) for q, start in zip(many, near, strict=True)]
    assert refined(robot, goals, near, steps=4) == pytest.approx(np.array(alone), abs=1e-7)
    assert conditionings(robot, many) == pytest.approx([k.conditioning(robot, q) for q in many])


def test_what_is_out_of_reach_is_not_a_number_and_takes_nothing_from_the_others() -> None:
    goals = np.array([k.forward(UR5E, UR5E.home).matrix] * 2)
    goals[1, 0, 3] += 5.0
    found = refined(UR5E, goals, np.array([UR5E.home] * 2), steps=4)
    assert found[0] == pytest.approx(UR5E.home)
    assert np.isnan(found[1]).all()
