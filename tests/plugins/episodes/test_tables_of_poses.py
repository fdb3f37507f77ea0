"""Tables of poses: any convention reads back as the same poses, what people do is read from them, and bad input is one clear sentence."""

from __future__ import annotations

import contextlib
import itertools
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
import yaml
from helpers.properties import examples
from helpers.tables_of_poses import RATE, Style, into_a_crate, opening, poses_of, pouring, worn, write
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cramlite import Engine
from cramlite.cli.main import main
from cramlite.model import Floats
from cramlite.plugin import UserError
from cramlite_plugins.episodes.tables.assembly import read_recording
from cramlite_plugins.episodes.tables.convention import axes_of
from cramlite_plugins.episodes.tables.mapping import read_mapping
from cramlite_plugins.episodes.tables.table import read_table
from cramlite_plugins.episodes.tables.tracked import recorded
from cramlite_plugins.shapes.bounds import box_around

ENGINE = Engine()
AXES = [
    tuple(s + a for s, a in zip(signs, order, strict=True))
    for order in itertools.permutations("xyz")
    for signs in itertools.product(("", "-"), repeat=3)
]
"""All 48 ways to lay axes, 24 of them left-handed."""
STYLES = st.builds(
    Style,
    unit=st.sampled_from([(1.0, "m"), (0.01, "cm"), (0.001, "mm"), (0.0254, "in"), (0.3048, "ft")]),
    axes=st.sampled_from(AXES), order=st.sampled_from(["xyzw", "wxyz"]),
    seconds=st.sampled_from([(1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns")]), json=st.booleans(), long=st.booleans(),
)  # fmt: skip


def poses_in(mapping: Path) -> dict[str, Floats]:
    """Track -> (N, 8) times and poses, as they are read."""
    said = read_mapping(mapping)
    assert said is not None
    found = recorded(read_table(mapping.parent / said.recording, said.kind), said)
    return {n: np.column_stack([r.times, r.poses]) for n, r in found.rows.items()}


def any_poses(seed: int) -> dict[str, Floats]:
    rng = np.random.default_rng(seed)
    count = 12
    turned = {n: Rotation.random(count, random_state=rng.integers(2**31)).as_quat(scalar_first=True) for n in ("right_hand", "bottle")}
    found = {n: np.hstack([rng.uniform(-2, 2, (count, 3)), q]) for n, q in turned.items()}
    for poses in found.values():
        poses[rng.integers(1, count - 1)] = np.nan
    return found


@examples(60)
@given(style=STYLES, seed=st.integers(0, 10**6))
def test_any_convention_reads_back_as_the_same_poses(style: Style, seed: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    given_ = any_poses(seed)
    read = poses_in(write(tmp_path_factory.mktemp("take"), given_, [], style))
    for name, poses in given_.items():
        seen = np.isfinite(poses).all(axis=1)
        assert np.allclose(read[name][:, 0], np.flatnonzero(seen) / RATE, atol=1e-9)
        assert np.allclose(read[name][:, 1:4], poses[seen, :3], atol=1e-9)
        assert np.allclose(np.abs(np.sum(read[name][:, 4:] * poses[seen, 3:], axis=1)), 1.0, atol=1e-9)


def test_another_convention_than_the_one_that_was_written_gives_other_poses(tmp_path: Path) -> None:
    mapping = write(tmp_path, any_poses(1), [], Style(axes=("z", "-x", "y")))
    said = yaml.safe_load(mapping.read_text())
    right = poses_in(mapping)["bottle"]
    mapping.write_text(yaml.safe_dump(said | {"axes": ["z", "x", "y"]}))
    assert not np.allclose(poses_in(mapping)["bottle"], right, atol=1e-3)


@pytest.mark.parametrize(("up", "handedness"), list(itertools.product(["x", "y", "z", "-x", "-y", "-z"], ["left", "right"])))
def test_axes_that_follow_from_the_upward_one_are_of_that_handedness(up: str, handedness: str) -> None:
    axes = axes_of(up, handedness)
    assert np.linalg.det(axes) == pytest.approx(1.0 if handedness == "right" else -1.0)
    assert axes[2, "xyz".index(up[-1])] == (-1.0 if up.startswith("-") else 1.0)


def test_presets_are_those_of_the_engines() -> None:
    assert axes_of("y", "left").tolist() == [[0, 0, 1], [-1, 0, 0], [0, 1, 0]]  # Unity's ROS packages: (z, -x, y)
    assert axes_of("z", "left").tolist() == [[1, 0, 0], [0, -1, 0], [0, 0, 1]]  # Unreal: (x, -y, z)


# What people do


CRATE = [("Grasping", "bottle"), ("PickingUp", "bottle", "table"), ("PuttingDown", "bottle", "crate"), ("Releasing", "bottle", "crate")]
POURED = [
    ("Grasping", "jug"), ("PickingUp", "jug", "table"), ("Pouring", "jug", "bowl"),
    ("PuttingDown", "jug", "table"), ("Releasing", "jug", "table"),
]  # fmt: skip
DONE: dict[str, tuple[Callable[[], dict[str, Floats]], list[str], list[tuple[str, ...]]]] = {
    "crate": (into_a_crate, ["table", "crate"], CRATE),
    "pouring": (pouring, ["table", "bowl"], POURED),
    "drawer": (opening, ["table"], [("Opening", "drawer")]),
}


def best(mapping: Path) -> list[tuple[str, ...]]:
    """The tasks of the best reading, without how the hand leaves."""
    sequence = next(ENGINE.interpret(ENGINE.read_episode(mapping)).sequences())
    return [(m.task.split(":")[1], *m.roles.values()) for m in sequence.matches if not m.task.endswith("Retracting")]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", DONE)
def test_what_a_person_did_is_read_from_a_noisy_table_with_gaps(name: str, seed: int, tmp_path: Path) -> None:
    make, things, said = DONE[name]
    style = Style(unit=(0.01, "cm"), axes=AXES[7 * seed], seconds=(1e-3, "ms"), json=seed == 1, long=seed == 2)
    assert best(write(tmp_path, worn(make(), seed), things, style)) == said


def test_a_bottle_that_is_put_beside_the_crate_is_not_in_it(tmp_path: Path) -> None:
    tracks = worn(into_a_crate(), 1)
    mapping = write(tmp_path, tracks, ["table", "crate"])
    said = yaml.safe_load(mapping.read_text())
    said["things"]["crate"]["at"]["position"][1] = 0.0
    mapping.write_text(yaml.safe_dump(said))
    assert best(mapping) == [*CRATE[:2], ("PuttingDown", "bottle", "table"), ("Releasing", "bottle", "table")]


def test_the_floor_of_a_crate_is_between_a_bottle_and_the_table(tmp_path: Path) -> None:
    """It is 3 mm thick, less than what counts as touching."""
    episode = ENGINE.read_episode(write(tmp_path, into_a_crate(), ["table", "crate"]))
    at_rest = [e for e in episode.at(7.0) if "bottle" in e.roles.values()]
    assert {tuple(e.roles.values()) for e in at_rest} == {("bottle", "crate"), ("crate", "bottle")}
    before = [e for e in episode.at(1.0) if "bottle" in e.roles.values()]
    assert {tuple(e.roles.values()) for e in before} == {("bottle", "table"), ("table", "bottle")}


def test_of_two_places_that_may_have_been_poured_into_one_is_named(tmp_path: Path) -> None:
    """Nothing is known of a thing without a class, so both may hold what was poured; neither is explained by the other."""
    mapping = write(tmp_path, pouring(), ["table", "bowl"])
    said = yaml.safe_load(mapping.read_text())
    del said["things"]["table"]["class"]
    mapping.write_text(yaml.safe_dump(said))
    found = ENGINE.interpret(ENGINE.read_episode(mapping))
    poured = [[m.roles["Destination"] for m in s.matches if m.task == "soma:Pouring"] for s in itertools.islice(found.sequences(), 2)]
    assert sorted(poured) == [["bowl"], ["table"]]


def test_a_table_is_not_poured_into(tmp_path: Path) -> None:
    found = ENGINE.interpret(ENGINE.read_episode(write(tmp_path, pouring(), ["table"])))
    assert not any(m.task == "soma:Pouring" for action in found.actions for m in action.matches)


def test_a_drawer_that_stays_closed_is_not_opened(tmp_path: Path) -> None:
    tracks = opening()
    tracks["drawer"] = poses_of(np.tile([0.7, 0.0, 0.6], (len(tracks["drawer"]), 1)))
    episode = ENGINE.read_episode(write(tmp_path, tracks, ["table"]))
    assert not any(e.type == "soma:Opening" for e in episode.events)


def test_gripper_column_becomes_the_opening_of_the_hand(tmp_path: Path) -> None:
    mapping = write(tmp_path, into_a_crate(), ["table", "crate"])
    rows = (tmp_path / "take.csv").read_text().splitlines()
    closed = [int(2.0 < float(r.split(",")[0]) < 5.4) for r in rows[1:]]
    (tmp_path / "take.csv").write_text("\n".join([rows[0] + ",grip", *(f"{r},{c}" for r, c in zip(rows[1:], closed, strict=True))]))
    said = yaml.safe_load(mapping.read_text())
    said["hands"]["right_hand"]["gripper"] = {"column": "grip", "closed": 1, "open": 0, "width": 0.1}
    mapping.write_text(yaml.safe_dump(said))
    episode = ENGINE.read_episode(mapping)
    assert float(episode.sampled("opening", 1.0)) == pytest.approx(0.1)  # type: ignore[arg-type]
    assert float(episode.sampled("opening", 4.0)) == 0.0  # type: ignore[arg-type]
    assert best(mapping) == CRATE


def test_frame_of_another_track(tmp_path: Path) -> None:
    """A thing that is written in the frame of a cart moves with it."""
    turned = np.array([1.0, 0, 0, 0])
    cart = np.array([[0.1 * k, 0, 0, *turned] for k in range(10)])
    hand, bottle = cart + np.array([0, 1, 0, 0, 0, 0, 0]), np.tile([0.5, 0, 0, *turned], (10, 1))
    mapping = write(tmp_path, {"right_hand": hand, "bottle": bottle, "cart": cart}, [])
    said = yaml.safe_load(mapping.read_text())
    said["things"]["bottle"]["in"] = "cart"
    mapping.write_text(yaml.safe_dump(said))
    assert ENGINE.read_episode(mapping).tracks["bottle"].poses[-1, 0] == pytest.approx(1.4)


@pytest.mark.parametrize("hollow", [False, True])
def test_mesh_in_the_unit_and_axes_of_the_recording(tmp_path: Path, hollow: bool) -> None:
    """A left-handed mesh in millimetres: the box that it is, convex or without a lid, in our axes."""
    style = Style(unit=(0.001, "mm"), axes=("z", "-x", "y"))
    parts = [trimesh.creation.box((80, 200, 60))]
    if hollow:
        inner = trimesh.creation.box((76, 200, 56))
        inner.apply_translation([0, 4, 0])
        parts = [parts[0].difference(inner)]
    parts[0].apply_translation([0, 100, 0])
    parts[0].export(tmp_path / "tin.stl")
    mapping = write(tmp_path, into_a_crate(), [], style)
    said = yaml.safe_load(mapping.read_text())
    said["things"]["bottle"]["shape"] = {"mesh": "tin.stl"}
    mapping.write_text(yaml.safe_dump(said))
    entity = ENGINE.read_episode(mapping).entity("bottle")
    low, high = box_around(entity.geoms)
    assert np.allclose(low, [-0.03, -0.04, 0.0], atol=1e-6) and np.allclose(high, [0.03, 0.04, 0.2], atol=1e-6)
    assert [g.shape for g in entity.geoms] == (["box"] * 5 if hollow else ["convex"])


def test_door_turns_by_as_much_as_its_poses_do(tmp_path: Path) -> None:
    turned = np.linspace(0, np.pi / 3, 60)
    door = np.column_stack([np.tile([0.5, 0, 0.5], (60, 1)), np.cos(turned / 2), 0 * turned, 0 * turned, np.sin(turned / 2)])
    hand = poses_of(np.column_stack([0.5 - 0.4 * np.sin(turned), 0.4 * np.cos(turned), np.full(60, 0.5)]))
    mapping = write(tmp_path, {"right_hand": hand, "door": door}, [])
    said = yaml.safe_load(mapping.read_text())
    said["things"]["door"] = {"class": "soma:Door", "opens": {"turns": 90}}
    mapping.write_text(yaml.safe_dump(said))
    episode = ENGINE.read_episode(mapping)
    assert float(episode.sampled("joint:door", 60 / RATE)) == pytest.approx(np.pi / 3, abs=0.1)  # type: ignore[arg-type]
    assert episode.entity("door").properties["joint_upper"] == pytest.approx(np.pi / 2)


@pytest.mark.parametrize(("gaps", "mark"), [(["zero"], "0"), ([-9999], "-9999"), (["nan"], "nan")])
def test_marks_of_gaps(tmp_path: Path, gaps: list[Any], mark: str) -> None:
    mapping = write(tmp_path, into_a_crate(), [])
    for axis in "xyz":
        edited(f"bottle.p{axis}", lambda cells: [mark if 10 <= k < 20 else c for k, c in enumerate(cells)])(tmp_path)
    mapped(lambda m: m.update(gaps=gaps))(tmp_path)
    assert len(poses_in(mapping)["bottle"]) == len(poses_in(mapping)["right_hand"]) - 10
    mapped(lambda m: m.update(gaps=["empty"]))(tmp_path)
    if mark == "0":
        assert len(poses_in(mapping)["bottle"]) == len(poses_in(mapping)["right_hand"])
    else:
        with pytest.raises(UserError, match="gaps"):
            poses_in(mapping)


def test_column_that_says_what_was_seen(tmp_path: Path) -> None:
    mapping = write(tmp_path, into_a_crate(), [])
    rows = (tmp_path / "take.csv").read_text().splitlines()
    seen = ["bottle.ok,right_hand.ok", *(f"{int(k >= 7)},1" for k in range(len(rows) - 1))]
    (tmp_path / "take.csv").write_text("\n".join(f"{r},{s}" for r, s in zip(rows, seen, strict=True)))
    mapped(lambda m: m.update(valid="{name}.ok"))(tmp_path)
    assert len(poses_in(mapping)["right_hand"]) - len(poses_in(mapping)["bottle"]) == 7


# Motion capture


def optitrack(folder: Path, unit: str = "Millimeters", rotation: str = "Quaternion") -> Path:
    """Motive's export of a bottle that is put into a crate: y up, rigid bodies among markers."""
    tracks, style = worn(into_a_crate(), 3), Style(unit=(0.001, "mm"), axes=("z", "x", "y"))
    written = {n: style.written(p) for n, p in tracks.items()}
    bodies = ["right_hand", "bottle"]
    kinds, axes = ["Rotation"] * 4 + ["Position"] * 3 + ["Mean Marker Error"], [*"XYZWXYZ", ""]
    head = [
        ["Format Version", "1.23", "Take Name", "take", "Capture Frame Rate", "120.0", "Rotation Type", rotation, "Length Units", unit],
        [], ["", "Type", *["Rigid Body"] * 16, *["Marker"] * 3], ["", "Name", *(b for b in bodies for _ in range(8)), *["Unlabeled 1"] * 3],
        ["", "ID", *["1"] * 8, *["2"] * 8, *["3"] * 3], ["", "", *kinds * 2, *["Position"] * 3],
        ["Frame", "Time (Seconds)", *axes * 2, *"XYZ"],
    ]  # fmt: skip
    rows = []
    for k in range(len(written["bottle"])):
        cells = [["" if np.isnan(v) else f"{v:.6f}" for v in written[b][k]] for b in bodies]
        rows.append([str(k), f"{k / RATE:.6f}", *(x for c in cells for x in (*c[3:], *c[:3], "0.1")), "1", "2", "3"])
    (folder / "take.csv").write_text("\n".join(",".join(r) for r in [*head, *rows]) + "\n")
    return _capture(folder, "optitrack", style, {})


def vicon(folder: Path) -> Path:
    """Tracker's export: millimetres, z up, a rate instead of times."""
    written = {n: Style(unit=(0.001, "mm")).written(p) for n, p in worn(into_a_crate(), 4).items()}
    bodies, axes = ["right_hand", "bottle"], ["RX", "RY", "RZ", "RW", "TX", "TY", "TZ"]
    names = ["", "", *(c for b in bodies for c in (f"{b}:{b}", *[""] * 6))]
    rows = [["Objects"], ["120"], names, ["Frame", "Sub Frame", *axes * 2], ["", "", *["", "", "", "", "mm", "mm", "mm"] * 2]]
    for k in range(len(written["bottle"])):
        cells = [["" if np.isnan(v) else f"{v:.6f}" for v in written[b][k]] for b in bodies]
        rows.append([str(k + 1), "0", *(x for c in cells for x in (*c[3:], *c[:3]))])
    (folder / "take.csv").write_text("\n".join(",".join(r) for r in rows) + "\n\nTrajectories\n120\n")
    return _capture(folder, "vicon", Style(unit=(0.001, "mm")), {})


def _capture(folder: Path, kind: str, style: Style, more: dict[str, Any]) -> Path:
    said = yaml.safe_load(write(_apart(folder), into_a_crate(), ["table", "crate"], style).read_text())
    kept = {k: said[k] for k in ("recording", "hands", "things")}
    mapping = folder / "take.yaml"
    mapping.write_text(yaml.safe_dump({**kept, "format": kind, **more}))
    return mapping


def _apart(folder: Path) -> Path:
    (folder / "apart").mkdir()
    return folder / "apart"


@pytest.mark.parametrize("export", [optitrack, vicon])
def test_exports_of_motion_capture_need_no_columns_and_no_units(export: Callable[[Path], Path], tmp_path: Path) -> None:
    assert best(export(tmp_path)) == CRATE


def test_header_of_a_capture_is_believed_and_contradictions_are_refused(tmp_path: Path) -> None:
    mapping = optitrack(tmp_path, unit="Meters")
    with pytest.raises(UserError, match=r"apart.*'length'"):
        ENGINE.read_episode(mapping)
    mapping.write_text(mapping.read_text() + "\nlength: mm\n")
    with pytest.raises(UserError, match="contradicts the recording's own header, which says m"):
        ENGINE.read_episode(mapping)


def test_a_capture_with_angles_is_refused_with_what_to_export(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="'XYZ'; export them as quaternions"):
        ENGINE.read_episode(optitrack(tmp_path, rotation="XYZ"))


def test_angles_about_axes_are_read_where_the_mapping_says_which(tmp_path: Path) -> None:
    mapping = write(tmp_path, any_poses(5), [])
    said = yaml.safe_load(mapping.read_text())
    right = poses_in(mapping)
    rows = [line.split(",") for line in (tmp_path / "take.csv").read_text().splitlines()]
    for row in rows[1:]:
        for first in (4, 11):
            if row[first]:
                angles = Rotation.from_quat([float(v) for v in row[first : first + 4]]).as_euler("XYZ", degrees=True)
                row[first : first + 4] = [*(repr(float(a)) for a in angles), ""]
    (tmp_path / "take.csv").write_text("\n".join(",".join(r) for r in rows))
    said |= {"rotation": "euler_XYZ", "angles": "deg", "columns": said["columns"] | {"rotation": said["columns"]["rotation"][:3]}}
    mapping.write_text(yaml.safe_dump(said))
    for name, rows_ in poses_in(mapping).items():
        assert np.allclose(np.abs(np.sum(rows_[:, 4:] * right[name][:, 4:], axis=1)), 1.0)


# Bad input: one clear paragraph, exit code 2


def edited(column: str, change: Callable[[list[str]], list[str]]) -> Callable[[Path], None]:
    """Change a column's cells in the CSV file."""

    def run(folder: Path) -> None:
        rows = [line.split(",") for line in (folder / "take.csv").read_text().splitlines()]
        at = rows[0].index(column)
        for row, cell in zip(rows[1:], change([r[at] for r in rows[1:]]), strict=True):
            row[at] = cell
        (folder / "take.csv").write_text("\n".join(",".join(r) for r in rows))

    return run


def mapped(change: Callable[[dict[str, Any]], object]) -> Callable[[Path], None]:
    """Change the mapping file."""

    def run(folder: Path) -> None:
        said = yaml.safe_load((folder / "take.yaml").read_text())
        change(said)
        (folder / "take.yaml").write_text(yaml.safe_dump(said))

    return run


def lines(keep: Callable[[list[str]], list[str]]) -> Callable[[Path], None]:
    """Change the lines of the CSV file."""

    def run(folder: Path) -> None:
        (folder / "take.csv").write_text("\n".join(keep((folder / "take.csv").read_text().splitlines())))

    return run


def backwards(cells: list[str]) -> list[str]:
    return [*cells[:50], "0.1", *cells[51:]]


def million(cells: list[str]) -> list[str]:
    return [c and str(1000 * float(c)) for c in cells]


BAD: dict[str, tuple[Callable[[Path], None], str]] = {
    "metres that are millimetres": (mapped(lambda m: m.update(length="m", things={"bottle": {}})), r"apart.*right.*'length: mm'"),
    "millimetres that are metres": (mapped(lambda m: m.update(length="mm")), r"no hand moves farther than .* mm"),
    "one axis far away": (edited("bottle.px", lambda c: [v and str(float(v) + 100) for v in c]), "apart"),
    "seconds that are milliseconds": (edited("t", million), r"s lie between two rows.*unit of time"),
    "time runs backwards": (edited("t", backwards), r"take.csv:52: time runs backwards, from .* to 0.1 s"),
    "time is text": (edited("t", lambda c: ["noon", *c[1:]]), r"take.csv:2: 'noon' in column 't' is no number"),
    "time is missing": (edited("t", lambda c: ["", *c[1:]]), r"take.csv:2: column 't' is empty"),
    "a gap that nobody announced": (edited("bottle.px", lambda c: ["nan", *c[1:]]), r"csv:2: column 'bottle.px' is nan.*\[empty, nan\]"),
    "a position that is infinite": (edited("bottle.px", lambda c: ["inf", *c[1:]]), "column 'bottle.px' is inf"),
    "quaternions that are none": (edited("bottle.qw", lambda c: ["0.5"] * len(c)), r"of 'bottle' has the length .* instead of 1"),
    "missing column": (lines(lambda rows: [rows[0].replace("bottle.px", "bottle_x"), *rows[1:]]), "no column 'bottle.px'.*did you mean"),
    "unknown track": (mapped(lambda m: m["things"].update(cup={})), "there is no column 'cup.px'"),
    "one row": (lines(lambda rows: rows[:2]), "'right_hand' was seen in 1 of 1 rows"),
    "header alone": (lines(lambda rows: rows[:1]), "has a header and no rows"),
    "empty file": (lines(lambda _: []), "the recording is empty"),
    "cut off": (lines(lambda rows: [*rows[:20], rows[20][:30]]), r"take.csv:21: this row has \d+ cells, and the header 15"),
    "two columns of one name": (lines(lambda rows: [rows[0].replace("bottle.px", "t"), *rows[1:]]), "two columns are called 't'"),
    "no such recording": (lambda f: (f / "take.csv").unlink(), "take.csv: the recording cannot be read"),
    "no text": (lambda f: (f / "take.csv").write_bytes(b"\xff\xfe\x00\x01" * 40), "no text of a table"),
    "unknown key": (mapped(lambda m: m.update(unit="mm")), "take.yaml:.*unknown key 'unit'"),
    "unknown unit": (mapped(lambda m: m.update(length="furlong")), "'length' is 'furlong'.*m, dm, cm"),
    "unknown convention": (mapped(lambda m: m.update(convention="blender")), "'convention: blender' is none of ros, unity"),
    "no handedness": (mapped(lambda m: (m.pop("axes"), m.update(up="y"))), "'handedness' is missing.*'handedness: left'"),
    "axes twice": (mapped(lambda m: m.update(axes=["x", "x", "z"])), "needs x, y and z once each"),
    "axes against handedness": (mapped(lambda m: m.update(handedness="left")), "makes the recording right-handed"),
    "no columns of rotations": (mapped(lambda m: m["columns"].pop("rotation")), "positions alone do not say what tilts.*0, 0, 0 and 1"),
    "no rotation": (mapped(lambda m: m.pop("rotation")), "'rotation' is missing.*xyzw or wxyz"),
    "no time": (mapped(lambda m: m.pop("time")), "nothing says when"),
    "a rate of rows that name their track": (
        mapped(lambda m: (m.update(time={"rate": 120}), m["columns"].update(track="t"))), "several rows are of one instant"
    ),
    "no hand": (mapped(lambda m: m.update(hands={})), "name one hand at least"),
    "a hand that is a thing": (mapped(lambda m: m["hands"].update(bottle={})), "'bottle' is both a hand and a thing"),
    "two shapes": (mapped(lambda m: m["things"]["bottle"]["shape"].update(box=[1, 1, 1])), "a shape is one of box"),
    "no such mesh": (mapped(lambda m: m["things"]["bottle"].update(shape={"mesh": "no.stl"})), "no.stl"),
    "a frame that is no track": (mapped(lambda m: m["things"]["bottle"].update({"in": "cart"})), "'in: cart' of 'bottle' is no track"),
    "three columns for a quaternion": (mapped(lambda m: m["columns"]["rotation"].pop()), "has 3 columns, and 'xyzw' needs 4"),
    "no gripper column": (mapped(lambda m: m["hands"]["right_hand"].update(gripper={"column": "g"})), "there is no column 'g'"),
    "a gripper that never moves": (
        mapped(lambda m: m["hands"]["right_hand"].update(gripper={"column": "t", "closed": 1, "open": 1})), "two different values"
    ),
    "hands without columns": (mapped(lambda m: m.pop("columns")), "nothing says which columns"),
    "a list": (lambda f: (f / "take.yaml").write_text("- recording"), "is in no format that a plugin reads"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_clear_paragraph(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spoil, said = BAD[name]
    unit = (0.001, "mm") if name == "metres that are millimetres" else (1.0, "m")
    mapping = write(tmp_path, into_a_crate(), ["table", "crate"], Style(unit=unit))
    spoil(tmp_path)
    assert main(["interpret", str(mapping)]) == 2
    error = capsys.readouterr().err
    assert re.search(said, error), error
    assert error.startswith("cramlite: ") and error.count("\n") == 1 and "Traceback" not in error


@examples(40)
@given(data=st.data(), file=st.sampled_from(["take.csv", "take.yaml"]))
def test_damaged_files_are_read_or_refused(data: st.DataObject, file: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("take")
    mapping = write(folder, {n: p[::20] for n, p in into_a_crate().items()}, ["table", "crate"])
    content = bytearray((folder / file).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        content[at : at + data.draw(st.integers(0, 30))] = data.draw(st.binary(max_size=6))
    (folder / file).write_bytes(bytes(content))
    with contextlib.suppress(UserError):
        read_recording(mapping)


def test_unspoilt_recording_is_read(tmp_path: Path) -> None:
    mapping = write(tmp_path, into_a_crate(), ["table", "crate"])
    assert main(["interpret", str(mapping)]) == 0
    assert main(["interpret", str(tmp_path)]) == 2  # the mapping is not called recording.yaml
    mapping.rename(tmp_path / "recording.yaml")
    assert main(["interpret", str(tmp_path)]) == 0


def test_json_that_is_broken_names_its_line(tmp_path: Path) -> None:
    mapping = write(tmp_path, into_a_crate(), ["table", "crate"], Style(json=True))
    text = (tmp_path / "take.jsonl").read_text().splitlines()
    (tmp_path / "take.jsonl").write_text("\n".join([*text[:6], text[6][:-9], *text[7:]]))
    with pytest.raises(UserError, match=r"take\.jsonl:7: no JSON"):
        ENGINE.read_episode(mapping)
    assert json.loads(text[0])


# From there to a program: docs/how-to/own_recording.md shows the one that succeeds


WORLD = """
scenario: own_recording
title: What somebody showed, in another world
demonstration: take.yaml
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: counter, model: table, at: {position: [2, 0.2, 0.15]}, with: {size: [0.3 m, 0.3 m, 20 mm]}}
  - {name: flask, model: bottle, at: {position: [2, 0.2, 0.26]}}
  - {name: basket, model: basket, at: {position: [0.5, -0.25, 0.01]}}
"""


def test_of_a_bottle_that_is_out_of_reach_there_is_no_program(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(tmp_path, into_a_crate(), ["table", "crate"])
    (tmp_path / "own.yaml").write_text(WORLD)
    assert main(["resolve", str(tmp_path / "own.yaml"), "--twins", "0", "--no-report", "--out", str(tmp_path / "out")]) == 1
    assert "reach" in capsys.readouterr().err
