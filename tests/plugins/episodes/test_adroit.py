"""A door with a lever, as hand_dapg records people's hands: recordings made from the scene's kinematics are read and learned from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cramlite import Engine
from cramlite.interpretation.timeline import Timeline
from cramlite.learning.from_episodes import learn_task
from cramlite.learning.learner import covers
from cramlite.learning.span import Span
from cramlite.model import Episode, Floats
from cramlite.plugin import UserError

ENGINE = Engine()
FRAME = np.array([-0.15, 0.24, 0.38])


def observed(lever: Floats, hinge: Floats, frame: Floats = FRAME, away: float = 0.03, curled: float = 0.0) -> Floats:
    """Observations of a palm that comes to the handle, turns with the door, about the forearm's second axis, which is upright, and leaves.

    Args:
        away: how far it stays before the handle [m].
        curled: angle of each joint of the fingers [rad]; at 0 they point at the door.
    """
    seen, t = np.zeros((len(lever), 39)), np.linspace(0, 1, len(lever))
    way = away + 0.2 * np.clip(np.maximum(1 - t / 0.1, t / 0.05 - 19), 0, 1)
    for k, (turned, opened) in enumerate(zip(lever, hinge, strict=True)):
        door = Rotation.from_rotvec([0, 0, opened])
        pivot = frame + np.array([0.6, 0, 0])
        at = pivot + door.apply(np.array([-0.31 - 0.15, 0, -0.025]) + Rotation.from_rotvec([0, turned, 0]).apply([0.15, -0.15, 0]))
        seen[k, 1], seen[k, 27:29] = opened, (turned, opened)
        seen[k, [6, 7, 8, 10, 11, 12, 14, 15, 16, 19, 20, 21]] = curled
        seen[k, 29:32] = at + door.apply([0.0, -0.02 - way[k], -0.025])
        seen[k, 32:35] = at
    return seen


def recorded(folder: Path, lever: float, hinge: float, steps: int = 250, **hand: float) -> Path:
    """A recording: the hand waits, turns the lever from 0.5 to 1.25 s, then draws the door open."""
    t = np.linspace(0, 1, steps)
    turned, opened = lever * np.clip((t - 0.2) / 0.3, 0, 1), hinge * np.clip((t - 0.6) / 0.3, 0, 1)
    file = folder / "shown.npz"
    np.savez(file, observations=observed(turned, opened, **hand), actions=np.zeros((steps, 28)), door=FRAME)
    return file


def touched(episode: Episode) -> list[tuple[str, float, float]]:
    assert all(e.type == "soma:ContactState" and e.inferred and e.roles["a"] == "hand" for e in episode.events)
    return [(e.roles["b"], e.start, e.end) for e in episode.events]


def read(folder: Path, lever: float, hinge: float, steps: int = 250, **hand: float) -> Episode:
    return ENGINE.read_episode(recorded(folder, lever, hinge, steps, **hand))


def test_lever_and_door_have_their_joints(tmp_path: Path) -> None:
    found = read(tmp_path, 1.7, 1.2)
    assert found.effector == "hand" and {e.name for e in found.entities} == {"hand", "door", "lever"}
    assert found.extras["joint:lever"][-1] == pytest.approx(1.7, abs=0.02)  # relative to the door, which turned by 1.2
    assert found.extras["joint:door"][-1] == pytest.approx(1.2, abs=0.02)
    assert found.span[1] == pytest.approx(2.49)


def test_a_lever_is_no_content_of_its_door(tmp_path: Path) -> None:
    found = read(tmp_path, 1.7, 1.2)
    assert not any("contents" in e.name for e in found.entities) and "lever" in found.tracks


def test_the_hand_touches_the_lever_that_it_turns_and_opens_what_it_moves(tmp_path: Path) -> None:
    shown = read(tmp_path, 1.7, 1.2)
    [(thing, start, end)] = touched(shown)
    assert thing == "lever" and start < 0.5 and 2.2 < end < 2.49
    done = {(m.task, *m.roles.values()) for action in ENGINE.interpret(shown).actions for m in action.matches}
    assert {("soma:Opening", "lever"), ("soma:Opening", "door"), ("soma:Reaching", "lever")} <= done


@pytest.mark.parametrize(("away", "curled", "touches"), [(0.1, 0.0, True), (0.1, 1.5, False), (0.16, 0.0, False)])
def test_a_lever_that_turns_beyond_the_fingers_is_not_touched(tmp_path: Path, away: float, curled: float, touches: bool) -> None:
    found = read(tmp_path, 1.7, 0.0, away=away, curled=curled)
    assert [thing for thing, *_ in touched(found)] == ["lever"] * touches
    assert found.extras["joint:lever"][-1] == pytest.approx(1.7, abs=0.02)


def test_a_palm_in_the_door_touches_the_door(tmp_path: Path) -> None:
    assert {thing for thing, *_ in touched(read(tmp_path, 0.0, 1.2, away=0.0))} >= {"door"}


def test_a_handle_that_is_elsewhere_is_refused(tmp_path: Path) -> None:
    seen = observed(np.zeros(9), np.zeros(9))
    seen[:, 32] += 0.05
    np.savez(tmp_path / "other.npz", observations=seen, door=FRAME)
    with pytest.raises(UserError, match=r"50 mm from where the angles of lever and hinge put it.*another scene"):
        ENGINE.read_episode(tmp_path / "other.npz")


def test_a_finger_whose_angle_is_missing_is_refused(tmp_path: Path) -> None:
    seen = observed(np.zeros(9), np.zeros(9))
    seen[4, 12] = np.nan
    np.savez(tmp_path / "lost.npz", observations=seen, door=FRAME)
    with pytest.raises(UserError, match=r"lost\.npz: the observations of step 4 contain NaN"):
        ENGINE.read_episode(tmp_path / "lost.npz")


def test_other_arrays_are_not_read(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", observations=np.zeros((5, 12)), door=FRAME)
    with pytest.raises(UserError):
        ENGINE.read_episode(tmp_path / "other.npz")


def test_a_door_with_a_lever_is_learned_and_a_door_alone_is_another_task(tmp_path: Path) -> None:
    shown = [read(tmp_path, *one) for one in ((1.7, 1.2, 250), (1.8, 1.0, 280), (1.5, 1.4, 230))]
    found = learn_task("unlatching", [(one, None, None) for one in shown], ENGINE.knowledge)

    def recognised(lever: float, hinge: float) -> bool:
        one = read(tmp_path, lever, hinge)
        return bool(covers(found.learned, Span(Timeline(one, ENGINE.knowledge.taxonomy), *one.span)))

    assert recognised(1.6, 1.1)
    assert not recognised(0.0, 1.1) and not recognised(1.6, 0.0)
