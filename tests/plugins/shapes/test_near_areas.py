"""What is said not to be near an area has no point over, in or under it, however it is turned."""

from __future__ import annotations

from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Pose
from cramlite_plugins.objects.vessels import jug
from cramlite_plugins.shapes.bounds import corners, near

AREA = (-0.2, -0.1, 0.3, 0.1)
POT = jug("pot", Pose())
metres, angles = st.floats(-0.6, 0.6), st.floats(-3.0, 3.0)


@examples(200)
@given(metres, metres, st.tuples(angles, angles, angles))
def test_a_thing_with_a_point_in_an_area_is_near_it(x: float, y: float, turn: tuple[float, float, float]) -> None:
    pose = Pose.from_rotvec((x, y, 0.0), turn)
    points = corners(POT, pose)[:, :2]
    inside = ((points >= AREA[:2]) & (points <= AREA[2:])).all(axis=1)
    assert near(POT, pose, AREA) or not inside.any()


def test_a_thing_whose_handle_alone_is_over_an_area_is_near_it_and_one_a_metre_away_is_not() -> None:
    assert near(POT, Pose((-0.27, 0.0, 0.5)), AREA)
    assert not near(POT, Pose((1.3, 0.0, 0.0)), AREA) and not near(POT, Pose((0.0, -1.1, 0.0)), AREA)
