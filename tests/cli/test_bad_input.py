"""Bad input of every kind: one paragraph with place and remedy, the right exit code, never a traceback."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Ran, Run

from cramlite import find_scenario

ROBOT = "robot: {type: ur5e}"


def _is_clear(ran: Ran, code: int, *words: str) -> None:
    assert ran.code == code, ran.err
    assert "Traceback" not in ran.out + ran.err
    message = ran.err[ran.err.index("cramlite: ") :]
    for word in words:
        assert word in message
    if code == 2:
        assert message.count("\n") == 1, "one paragraph"


SPOILED = {
    "unknown key": (("robot:", "robbot:"), ":10", "'robbot'", "did you mean 'robot'"),
    "unknown key below": (("position: [0.87", "positon: [0.87"), ":13", "did you mean 'position'"),
    "task type": (("task: Grasping", "task: Graspin"), ":5", "did you mean 'Grasping'"),
    "role": (("Patient: tea", "Pateint: tea"), ":5", "did you mean 'Patient'"),
    "role without filler": ((", Patient: tea", ""), "needs a filler for its role 'Patient'"),
    "filler": (("Patient: tea", "Patient: teaa"), "did you mean 'tea'"),
    "task parameter": (("Patient: tea", "Patient: tea, parameters: {forze_n: 3}"), "did you mean 'force_n'"),
    "type of a task parameter": (("Patient: tea", "Patient: tea, parameters: {force_n: hard}"), "valid number"),
    "plugin to prefer": ((ROBOT, f"prefer: [graspin]\n{ROBOT}"), "did you mean 'grasping'"),
    "unit": (("-1 mm", "-1 inch"), ":12", "'inch'", "units: m, cm, mm"),
    "unit of another kind": (("-1 mm", "-1 kg"), ":12", "is not a unit of length"),
    "unit of a model parameter": (("300 g", "300 lb"), ":16", "'lb'", "units: kg, g"),
    "model parameter in another unit": (("300 g", "300 mm"), ":16", "is not a unit of mass"),
    "wrong type": (("yaw: 180 deg", "yaw: [1]"), ":13", "is not an angle"),
    "wrong type of a list": (("[0.87, 0, 0.45]", "far"), ":13", "position"),
    "YAML error": (("things:\n", "things: [\n"), ":12", "not valid YAML"),
    "tag": ((ROBOT, "robot: !robot {type: ur5e}"), ":10", "tag '!robot' is not allowed"),
    "tag of a scalar": (("model: boxed_product", "model: !x boxed_product"), ":15", "'!x'"),
    "tag that would run code": ((ROBOT, "prefer: !!python/object/apply:os.system [ls]"), "python/object", "not allowed"),
    "key given twice": ((ROBOT, f"{ROBOT}\n{ROBOT}"), ":11", "duplicate key"),
    "two things of one name": (("name: basket", "name: hook"), "two things are called 'hook'"),
    "thing called like the robot": (("name: floor", "name: arm"), "'arm' is used twice"),
    "model": (("model: basket", "model: baskett"), ":18", "did you mean 'basket'"),
    "model parameter": (("mass: 300 g", "masss: 300 g"), ":16", "did you mean 'mass'"),
    "length of a model parameter": (("[60 mm, 50 mm, 100 mm]", "[60 mm, 50 mm]"), ":16", "'size'"),
    "robot": (("ur5e", "ur7e"), ":10", "did you mean 'ur5e'"),
    "backend": ((ROBOT, f"backend: urscrip\n{ROBOT}"), ":10", "did you mean 'urscript'"),
    "class of a thing": (("model: basket", "model: basket, type: cram:Baskett"), ":18", "did you mean 'cram:Basket'"),
    "class of an object": ((ROBOT, f"objects: {{tea: {{types: [cram:Teabox]}}}}\n{ROBOT}"), ":10", "'types'", "did you mean 'cram:TeaBox'"),
    "feature of an object": ((ROBOT, f"objects: {{tea: {{features: [vrps:Whole]}}}}\n{ROBOT}"), ":10", "did you mean 'vrps:Hole'"),
    "affordance of an object": ((ROBOT, f"objects: {{tea: {{affords: [cram:Holding_]}}}}\n{ROBOT}"), ":10", "'affords' of object 'tea'"),
    "name in other letters": (("name: floor", "name: \u043f\u043e\u043b"), ":12", "is no name", "letters, digits and underscores"),
    "number of 400 digits": (("[0.87,", f"[{'9' * 400},"), ":13", f"'{'9' * 40}...' is not finite"),
    "angle without end": (("yaw: 180 deg", "yaw: .inf"), ":13", "an angle is a number in rad"),
    "character of no text": (("things:\n", "things: \0\n"), "not valid YAML", "control characters"),
    "robot file": ((ROBOT, "robot: {file: none.urdf}"), ":10", "none.urdf", "no other MJCF or URDF file"),
    "folder for a scene": ((ROBOT, f"world: {{file: .}}\n{ROBOT}"), ":10", "a folder"),
    "ontology file": ((ROBOT, f"ontologies: [none.ttl]\n{ROBOT}"), "none.ttl", "no such ontology"),
    "hanger": (("hanger: hook", "hanger: hok"), ":14", "did you mean 'hook'"),
    "world that does not compile": (("[2 m, 2 m, 20 mm]", "[0, 0, 0]"), ":12", "positive size"),
    "mass of nothing": (("300 g", "0"), ":14", "mass 0.0 kg", "between"),
    "mass that is no number": (("300 g", ".nan"), ":16", "nan"),
    "time step": ((ROBOT, f"physics: {{timestep: -1}}\n{ROBOT}"), ":10", "timestep", "greater than"),
    "large time step": ((ROBOT, f"physics: {{timestep: 10}}\n{ROBOT}"), ":10", "timestep", "less than"),
    "friction cone": ((ROBOT, f"physics: {{cone: round}}\n{ROBOT}"), ":10", "elliptic"),
    "friction": ((ROBOT, f"physics: {{pad_friction: -3}}\n{ROBOT}"), ":10", "pad_friction"),
    "impedance": ((ROBOT, f"physics: {{impratio: .inf}}\n{ROBOT}"), ":10", "impratio"),
    "budget": ((ROBOT, f"budget: {{expansion: 3}}\n{ROBOT}"), ":10", "did you mean 'expansions'"),
    "empty budget": ((ROBOT, f"budget: {{expansions: 0}}\n{ROBOT}"), ":10", "at least 1"),
    "two starts": ((ROBOT, f"designator: ParkingArms\n{ROBOT}"), "exactly one of", "tasks and designator"),
    "nothing to choose from": (("{thing: hook, ", "{thing: hook, with: {length: []}, "), "it has no entries, and needs at least 1"),
    "episode path": (("tasks:\n", "demonstration: nowhere\nignored:\n"), "'ignored'"),
}


@pytest.mark.parametrize("case", SPOILED)
def test_a_spoiled_scenario(case: str, spoiled: Callable[..., Path], run: Run, tmp_path: Path) -> None:
    change, *words = SPOILED[case]
    _is_clear(run("resolve", spoiled(change), "--no-report", "--out", tmp_path / "run"), 2, *words)


RUN_ON = {
    "robot": ("ur5e", "z" * 4000),
    "robot, in words": ("ur5e", "z " * 2000 + "z"),
    "ontology": (ROBOT, f"ontologies: [{'z' * 4000}]\n{ROBOT}"),
    "size": ("[60 mm, 50 mm, 100 mm]", f"[{'1, ' * 2000}1]"),
    "filler": ("Patient: tea", f"Patient: {'z' * 4000}"),
}


@pytest.mark.parametrize("case", RUN_ON)
def test_a_value_that_runs_on_is_not_told_whole(case: str, spoiled: Callable[..., Path], run: Run) -> None:
    ran = run("check", spoiled(RUN_ON[case]))
    _is_clear(ran, 2, " characters) ...")
    assert len(ran.err) < 700


@pytest.mark.parametrize(("text", "words"), [("", "nothing"), ("- a", "a list"), ("hello", "'hello'")])
def test_a_file_that_is_no_scenario(text: str, words: str, run: Run, tmp_path: Path) -> None:
    path = tmp_path / "no.yaml"
    path.write_text(text)
    _is_clear(run("resolve", path), 2, f"{path}:1", words)


def test_bytes_that_are_no_text(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "no.yaml"
    path.write_bytes(b"scenario: \xff\xfe")
    _is_clear(run("resolve", path), 2, "UTF-8")


def test_names_on_the_command_line(run: Run, tmp_path: Path, spoiled: Callable[..., Path]) -> None:
    _is_clear(run("tasks", "--block", "graspin"), 2, "did you mean 'grasping'")
    _is_clear(run("resolve", "fetch_from_hangar"), 2, "did you mean 'fetch_from_hanger'")
    _is_clear(run("tasks", "--plugin", tmp_path / "none.py"), 2, "none.py")
    _is_clear(run("interpret", tmp_path / "none"), 2, "There is no episode at")
    out = ("--no-report", "--out", tmp_path / "a")
    _is_clear(run("resolve", spoiled(), "--backend", "urscrip", *out), 2, "did you mean 'urscript'")
    _is_clear(run("resolve", spoiled(), "--seed", "-3", "--no-report", "--out", tmp_path / "b"), 2, "-3")
    _is_clear(run("goal", "hang_up_a_product", "--plans", "-3"), 2, "--plans -3")
    _is_clear(run("experiment", "libero", "--twins", "-4"), 2, "number of twins is -4")
    _is_clear(
        run("resolve", spoiled(("{thing: hook, ", "{thing: hok, ")), "--seed", "3", "--out", tmp_path / "c"),
        2, "did you mean 'hook'",
    )  # fmt: skip


@pytest.mark.parametrize("command", ["execute", "judge", "preflight", "controller", "view", "export", "goal"])
def test_a_seed_below_nought(command: str, run: Run, tmp_path: Path) -> None:
    place = {"controller": (), "goal": ("hang_up_a_product",), "export": (tmp_path, "--to", "csv")}.get(command, (tmp_path,))
    world = ("--world", "grasp_one_thing") if command in ("execute", "judge", "preflight") else ()
    _is_clear(run(command, *place, *world, "--seed", "-1"), 2, "The seed is -1", "0 (the world as written) or more")


@pytest.mark.parametrize(
    "words", [("view", "run", "--seconds", "-1"), ("controller", "--seconds", "nan"), ("controller", "--idle", "soon")]
)
def test_a_time_that_is_none(words: tuple[str, ...], process: Run) -> None:
    ran = process(*words)
    assert ran.code == 2 and f"argument {words[-2]}: '{words[-1]}' is no time; write a number of seconds" in ran.err


def test_where_nothing_can_be_written(run: Run, tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text("<mujoco><worldbody><geom type='box' size='1 1 .1'/></worldbody></mujoco>")
    _is_clear(run("import", tmp_path / "scene.xml", "--force", "--out", tmp_path), 2, "cannot be written: Is a directory")
    _is_clear(run("import", tmp_path / "scene.xml", "--out", tmp_path / "none" / "a.yaml"), 2, "cannot be written", "--out")


def test_arrays_that_are_none(run: Run, tmp_path: Path) -> None:
    """NumPy calls whatever is no archive of its own pickled data, and says how to read that unsafely."""
    (tmp_path / "rollout.npz").write_bytes(b"\x93 no archive")
    (tmp_path / "world.json").write_text("{}")
    for words in (("export", tmp_path, "--to", "csv", "--world", "grasp_one_thing"), ("perceive", tmp_path / "rollout.npz")):
        ran = run(*words)
        _is_clear(ran, 2, "rollout.npz", "no NumPy archive")
        assert "pickle" not in ran.err


def test_a_process_prints_one_paragraph(process: Run) -> None:
    _is_clear(process("resolve", "fetch_from_hangar"), 2, "did you mean 'fetch_from_hanger'")


def test_an_unreachable_goal_is_no_solution(run: Run, spoiled: Callable[..., Path], tmp_path: Path) -> None:
    path = spoiled(("[0.87, 0, 0.45]", "[2.87, 0, 0.45]"))
    ran = run("resolve", path, "--no-report", "--out", tmp_path / "run")
    _is_clear(ran, 1, "No solution", "Nearest miss", " m > ")


def test_no_solution_of_a_process_ends_with_its_reasons(process: Run, tmp_path: Path) -> None:
    text = find_scenario("tasks/opening_blocked").read_text().replace("type: ur5e", "type: fr3_2f85, at: {position: [0.1, 0, 0]}")
    (tmp_path / "opening.yaml").write_text(text)
    ran = process("resolve", tmp_path / "opening.yaml", "--no-report", "--out", tmp_path / "run")
    _is_clear(ran, 1, "No solution", "Nearest miss")
    assert ran.err.splitlines()[-1].startswith("  To try: ")  # a library printed what it had not cleaned up


def test_a_path_that_is_no_episode(run: Run, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("hello")
    _is_clear(run("interpret", tmp_path / "notes.txt"), 2, "notes.txt")
    (tmp_path / "empty").mkdir()
    _is_clear(run("interpret", tmp_path / "empty"), 2, "empty")


EMPTY = """
@hookimpl
def read_episode(path):
    return Episode("empty", (), (), {}, None) if path.name == "hello.none" else None
"""


def test_an_episode_with_no_events(run: Run, tmp_path: Path, plugin: Callable[[str, str], Path]) -> None:
    (tmp_path / "hello.none").write_text("")
    _is_clear(run("interpret", tmp_path / "hello.none", "--plugin", plugin("empty", EMPTY)), 2, "no events")


@pytest.mark.heavy
def test_a_page_is_written_over_pages_only(run: Run, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    episode = find_scenario("fetch_from_hanger").parent / "fetch_from_hanger" / "demonstration"
    for place in ("notes.txt", "."):
        _is_clear(run("interpret", episode, "--html", tmp_path / place), 2, "Choose another place")
    _is_clear(run("perceive", "fetch_from_hanger_camera", "--query", "type=cram:Product", "--out", tmp_path / "notes.txt"), 2, "notes.txt")
    assert (tmp_path / "notes.txt").read_text() == "mine"
    for _ in range(2):
        assert run("interpret", episode, "--html", tmp_path / "page.html").code == 0


def test_mujoco_neither_prints_nor_keeps_a_log(process: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It would warn of the number, and append that to MUJOCO_LOG.TXT in the user's folder."""
    monkeypatch.chdir(tmp_path)
    Path("scene.xml").write_text("<mujoco><worldbody><body name='b' pos='0 0 nan'><geom size='1'/></body></worldbody></mujoco>")
    ran = process("import", "scene.xml")
    assert ran.code == 2 and ran.err.startswith("cramlite: scene.xml:1: body 'b' has a pose") and ran.err.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["scene.xml"]
