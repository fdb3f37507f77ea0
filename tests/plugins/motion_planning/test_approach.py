"""No point of a geom moves faster, seen from another geom, than the bounds for parts of a line say."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from helpers.scenes import TABLE, make

from cramlite.model import Floats
from cramlite_plugins.motion_planning.joint_line import JointBlend, JointLine
from cramlite_plugins.motion_planning.planning_scene import PlanningScene

DIRECTIONS = np.random.default_rng(3).normal(size=(40, 3))


@pytest.fixture(scope="module")
def place() -> PlanningScene:
    return make(TABLE)


def surface(place: PlanningScene, g: int) -> Floats:
    """Farthest points of a geom in random directions, in its own frame (n, 3) [m]."""
    size = place.compiled.model.geom_size[g]
    if place.compiled.model.geom_type[g] == mujoco.mjtGeom.mjGEOM_BOX:
        return np.sign(DIRECTIONS) * size
    round_ = size[0] * DIRECTIONS[:, :2] / np.linalg.norm(DIRECTIONS[:, :2], axis=1)[:, None]
    return np.column_stack((round_, np.sign(DIRECTIONS[:, 2]) * size[1]))


def seen(place: PlanningScene, q: Floats, g: int, h: int) -> Floats:
    """The points of geom g in the frame of the body of geom h (n, 3) [m]."""
    place.tcp(q)
    data, body = place.data, int(place.compiled.model.geom_bodyid[h])
    world = surface(place, g) @ data.geom_xmat[g].reshape(3, 3).T + data.geom_xpos[g]
    return (world - data.xpos[body]) @ data.xmat[body].reshape(3, 3)


def lines() -> list[JointLine]:
    """Long and short lines and corners; the last corner turns back, so that the arm stops in its middle."""
    rng = np.random.default_rng(4)
    a, b, c = rng.uniform(-2.0, 2.0, (3, 3, 6))
    corners = [JointBlend(x + 0.3 * (p - x), x, x + 0.2 * (r - x)) for p, x, r in zip(a, b, c, strict=True)]
    short = [JointLine(x, x + 0.01 * p) for x, p in zip(a, b, strict=True)]
    return [*map(JointLine, a, b), *short, *corners, JointBlend(a[0], a[0] + 0.02 * b[0], a[0])]


def shares(place: PlanningScene, line: JointLine) -> list[float]:
    """Largest speed of any point over its bound, for pairs of geoms that no round geom is left out of, and parts."""
    movers, found = place.movers, []
    coaxial = (movers.moved != movers.turned).any(axis=1) | (movers.still != 1.0 - movers.moved).any(axis=1)
    moved = np.flatnonzero(movers.moved.any(axis=1) & ~coaxial).tolist()[::5]
    still = np.flatnonzero(~coaxial).tolist()[::5]
    pairs = [(g, h) for g in moved for h in still if (movers.moved[g] > movers.moved[h]).any()]
    for low, high, known in place._parts(line)[::2]:
        times = np.linspace(low, high, 9)
        for g, h in pairs:
            at = np.array([seen(place, line.at(t), g, h) for t in times])
            speed = np.linalg.norm(np.diff(at, axis=0), axis=-1).max() / (times[1] - times[0])
            found.append(float(speed) / known.between[place.chains.which[g, h]])
            assert known.between[place.chains.which[g, h]] <= known.most
    return found


@pytest.mark.parametrize("line", lines())
def test_no_point_is_faster_than_the_bound(place: PlanningScene, line: JointLine) -> None:
    found = shares(place, line)
    assert max(found) < 1.0 + 1e-9
    assert max(found) > 0.6, "bounds that are far too large cost checks"


def test_a_geom_that_no_joint_moves_against_another_does_not_approach_it(place: PlanningScene) -> None:
    apart, known = place.movers.apart(), place._parts(lines()[0])[0][2]
    speeds = np.array(known.between)[place.chains.which]
    assert (speeds[apart == 0] == 0.0).all() and (speeds[apart > 0] > 0.0).all()
