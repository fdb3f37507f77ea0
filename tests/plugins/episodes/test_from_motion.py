"""Events from motion alone: each with a motion that looks alike and must not count."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite.model import Entity, Episode, Floats, Geom, Pose, Track
from cramlite_plugins.episodes.detection.from_motion import infer
from cramlite_plugins.episodes.formats.neem import read_neem

SAMPLES = Path(__file__).resolve().parents[4] / "shared" / "data" / "neem"
TIMES = np.arange(0, 8, 0.1)


def poses(height: Callable[[Floats], Floats], side: Callable[[Floats], Floats] = lambda t: 0 * t) -> Floats:
    rows = np.zeros((len(TIMES), 7))
    rows[:, 0], rows[:, 2], rows[:, 3] = side(TIMES), height(TIMES), 1.0
    return rows


def lifted(times: Floats) -> Floats:
    """Up by 0.2 m from 2 s to 3 s, down from 6 s to 7 s."""
    return np.asarray(0.2 * np.clip(times - 2, 0, 1) - 0.2 * np.clip(times - 6, 0, 1))


def shaken(times: Floats) -> Floats:
    """To and fro by 30 mm, 1.5 Hz, from 3 s to 6 s."""
    return np.where((times > 3) & (times < 6), 0.03 * np.sin(2 * np.pi * 1.5 * (times - 3)), 0.0)


def recording(hand: Floats, cup: Floats, table: bool = False) -> Episode:
    hand = hand + np.array([0.1, 0, 0.05, 0, 0, 0, 0])
    moved = np.concatenate([[True], np.any(np.diff(cup, axis=0) != 0, axis=1)])
    entities = [Entity("hand", ()), Entity("cup", (), size=(0.08, 0.08, 0.1) if table else None)]
    tracks = {"hand": Track(TIMES, hand), "cup": Track(TIMES[moved], cup[moved])}
    if table:
        entities.append(Entity("table", (), size=(2, 2, 0.02)))
        tracks["table"] = Track(TIMES[:1], np.array([[0, 0, -0.06, 1, 0, 0, 0.0]]))
    return Episode("raw", tuple(entities), (), tracks, "hand")


def types(episode: Episode) -> list[str]:
    return [e.type for e in episode.events]


def test_lifting_shaking_and_putting_back() -> None:
    path = poses(lifted, shaken)
    found = infer(recording(path, path))
    assert set(types(found)) == {
        "soma:ContactState",
        "soma:SupportState",
        "cram:GraspState",
        "cram:Shaking",
    }
    assert all(e.inferred for e in found.events)
    (grasp,) = found.of("state", ["cram:GraspState"])
    assert (grasp.start, grasp.end) == pytest.approx((2.0, 7.0), abs=0.2)
    (shaking,) = found.of("action", ["cram:Shaking"])
    assert (shaking.start, shaking.end) == pytest.approx((3.0, 6.0), abs=0.6)
    stood = found.of("state", ["soma:SupportState"])
    assert [(e.start, e.end) for e in stood] == [(0.0, pytest.approx(2.2, abs=0.2)), (pytest.approx(6.9, abs=0.2), found.span[1])]
    assert {e.roles["supporter"] for e in stood} == {"support(cup)"}


def test_lifting_alone_is_no_shaking() -> None:
    found = types(infer(recording(poses(lifted), poses(lifted))))
    assert "cram:Shaking" not in found
    assert "cram:GraspState" in found and "soma:SupportState" in found


def test_a_hand_that_waves_beside_holds_nothing() -> None:
    assert types(infer(recording(poses(lifted, shaken), poses(lambda t: 0 * t)))) == []


def test_what_moves_otherwise_is_not_held() -> None:
    assert types(infer(recording(poses(lifted), poses(lambda t: -lifted(t))))) == []


def test_pushing_along_is_held_but_not_lifted() -> None:
    path = poses(lambda t: 0 * t, lifted)
    assert set(types(infer(recording(path, path)))) == {"cram:GraspState", "soma:ContactState"}


def test_tilting_far_is_pouring() -> None:
    path = poses(lifted)
    tilt = np.where((TIMES > 3.5) & (TIMES < 5.5), 1.5, 0.0)
    path[:, 3], path[:, 4] = np.cos(tilt / 2), np.sin(tilt / 2)
    cup = path.copy()
    hand = path * [1, 1, 1, 0, 0, 0, 0] + [0, 0, 0, 1, 0, 0, 0]
    (pouring,) = infer(recording(hand, cup)).of("action", ["soma:Pouring"])
    assert (pouring.start, pouring.end) == pytest.approx((3.5, 5.5), abs=0.2)
    assert "soma:Pouring" not in types(infer(recording(poses(lifted), poses(lifted))))


def test_shapes_tell_what_it_stood_on() -> None:
    found = infer(recording(poses(lifted), poses(lifted), table=True)).of("state", ["soma:SupportState"])
    assert [(e.roles["supporter"], e.inferred) for e in found] == [("table", True)] * 2
    unknown = infer(recording(poses(lifted), poses(lifted))).of("state", ["soma:SupportState"])
    assert [(e.roles["supporter"], e.inferred) for e in unknown] == [("support(cup)", True)] * 2


def in_a_box(geoms: tuple[Geom, ...], height: float = 0.02) -> list[tuple[str, ...]]:
    """A cup that is put down where a box stands, from (0.95, -0.1, 0) to (1.15, 0.1, 0.1)."""
    whole = recording(poses(lifted, lambda t: np.clip(t - 3, 0, 1)), poses(lifted, lambda t: np.clip(t - 3, 0, 1)))
    box = Entity("box", (), pose=Pose((1.0, 0.0, height)), size=(0.2, 0.2, 0.15), geoms=geoms)
    cup = Entity("cup", (), size=(0.06, 0.06, 0.1))
    found = infer(replace(whole, entities=(whole.entities[0], cup, box)))
    return [tuple(e.roles.values()) for e in found.of("state", ["soma:ContainmentState"]) if e.inferred]


WALLS = tuple(Geom("box", (0.005, 0.1, 0.075), Pose((x, 0, 0))) for x in (-0.1, 0.1))


def test_what_is_put_into_a_box_is_contained() -> None:
    assert in_a_box(()) == [("box", "cup")]
    assert in_a_box(WALLS) == [("box", "cup")]


def test_what_is_in_no_cavity_is_not_contained() -> None:
    assert in_a_box((Geom("box", (0.1, 0.1, 0.075)),)) == []
    assert in_a_box((), height=0.2) == []
    assert in_a_box((), height=-0.2) == []


def test_what_rests_touches_what_it_stands_on() -> None:
    found = infer(recording(poses(lifted), poses(lifted), table=True)).of("state", ["soma:ContactState"])
    assert sum(set(e.roles.values()) == {"cup", "table"} for e in found) == 2


def test_recorded_states_are_left_alone() -> None:
    once = infer(recording(poses(lifted), poses(lifted)))
    assert infer(once) is once


@pytest.mark.skipif(not SAMPLES.exists(), reason="the real samples are not here")
def test_a_real_container_is_grasped_lifted_shaken_and_put_back() -> None:
    found = read_neem(SAMPLES / "pouring_shaking")
    assert found is not None
    order = [e.type for e in found.events if e.roles.get("object") == "salt_container"]
    assert order == ["cram:GraspState", "cram:Shaking"]  # tilted all the while, which is how it is shaken
    assert {e.roles.get("object", "salt_container") for e in found.events} == {"salt_container"}
