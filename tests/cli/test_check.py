"""``cramlite check`` and ``cramlite schema``."""

from __future__ import annotations

import json
import re
from pathlib import Path
from shutil import copytree

import jsonschema
import pytest
import yaml
from conftest import ROOT, Run
from helpers.as_a_user import cramlite

SCENARIOS = sorted((ROOT / "scenarios").glob("*.yaml"))
RULES = sorted((ROOT / "task_rules").glob("*.yaml"))
BAD_PROGRAM = """def p():
  movej([0, -90, 90, 0, 0, 0])
  movel(p[550, 0, 300, 0, 3.14, 0])
  movel(p[0.5, 0, 0.3, 0, 180, 0])
  while not is_steady():
    sync()
  end
  sleep("long")
  if 1:
    textmsg("one")
  end
  halt
  textmsg("never")
end
"""


def schema(kind: str) -> object:
    return json.loads(cramlite("schema", kind).stdout)


def plain(path: Path) -> object:
    return yaml.safe_load(path.read_text())


@pytest.mark.parametrize("kind", ["scenario", "rule"])
def test_what_is_shipped_fits_its_schema(kind: str) -> None:
    validator = jsonschema.Draft202012Validator(schema(kind))
    files = SCENARIOS if kind == "scenario" else RULES
    assert files
    for path in files:
        assert not list(validator.iter_errors(plain(path))), path


@pytest.mark.parametrize(
    ("kind", "change"),
    [
        ("scenario", {"robot": 3}),
        ("scenario", {"no_such_key": 1}),
        ("scenario", {"unknown_error": {"thing": "hook", "position": "5 apples"}}),
        ("scenario", {"tasks": [{"Patient": "without a task"}]}),
        ("rule", {"when": []}),
        ("rule", {"pre": "grasps(G, P)"}),
        ("rule", {"roles": {"patient": "soma:Patient"}}),
    ],
)
def test_what_is_wrong_does_not_fit(kind: str, change: dict[str, object]) -> None:
    data = plain((SCENARIOS if kind == "scenario" else RULES)[0])
    assert isinstance(data, dict)
    assert list(jsonschema.Draft202012Validator(schema(kind)).iter_errors({**data, **change}))


@pytest.mark.parametrize("name", ["fetch_from_hanger", "place_on_shelf", ROOT / "task_rules" / "grasping.yaml"])
def test_what_is_right_passes(name: object) -> None:
    done = cramlite("check", name)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("model: ", "modell: ", "modell"),
        ("type: ur5e", "type: ur5x", "no robot 'ur5x'"),
        ("task: PickUp", "task: PickUpp", "PickUpp"),
    ],
)
def test_a_scenario_that_is_wrong_is_explained_with_its_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = (ROOT / "scenarios" / "place_on_shelf.yaml").read_text()
    assert old in text
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace(old, new, 1))
    done = cramlite("check", path)
    assert done.returncode == 2 and said in done.stderr and f"{path}:" in done.stderr and "Traceback" not in done.stderr


GOAL = """\
scenario: trays
goal: [{goal}]
robot: {{type: ur5e}}
things:
  - {{name: tray, model: table, at: {{position: [0.35, -0.4, 50 mm]}}, with: {{size: [30 cm, 30 cm, 20 mm]}}}}
  - {{name: mug, model: can, at: {{position: [0.45, 0.25, 59 mm]}}}}
"""


@pytest.mark.parametrize(
    ("goal", "code", "said"),
    [
        ("mug on tray", 0, "with the plan Grasping(mug) -> "),
        ("mug on tray, tray on mug", 2, "yaml:2) contradict each other: 'mug' would have to carry itself"),
    ],
)
def test_whether_tasks_achieve_a_goal(tmp_path: Path, goal: str, code: int, said: str) -> None:
    path = tmp_path / "trays.yaml"
    path.write_text(GOAL.format(goal=goal))
    done = cramlite("check", path)
    assert done.returncode == code
    assert said in (done.stderr if code else done.stdout)


@pytest.mark.parametrize(("tasks", "code"), [("[ParkingArms]", 0), ("[]", 2)])
def test_a_scenario_has_a_task(tmp_path: Path, tasks: str, code: int) -> None:
    path = tmp_path / "idle.yaml"
    path.write_text(f"scenario: idle\ntasks: {tasks}\nrobot: {{type: ur5e}}\nthings: []\n")
    done = cramlite("check", path)
    assert done.returncode == code, done.stderr
    assert code == 0 or f"{path}:2: There is no task" in done.stderr


def shown(folder: Path, old: str = "", new: str = "") -> Path:
    """The scenario fetch_from_hanger with its demonstration beside it, changed in one place."""
    text = (ROOT / "scenarios" / "fetch_from_hanger.yaml").read_text()
    assert old in text
    path = folder / "mine.yaml"
    path.write_text(text.replace(old, new))
    copytree(ROOT / "scenarios" / "fetch_from_hanger", folder / "fetch_from_hanger")
    return path


def test_a_demonstration_is_read_and_its_objects_are_looked_for(tmp_path: Path) -> None:
    done = cramlite("check", shown(tmp_path))
    assert done.returncode == 0 and "read as Grasping(cram:TeaBox) -> ExtractHoleFromPeg(cram:TeaBox, vrps:Peg)" in done.stdout, done.stderr


def test_a_demonstration_that_cannot_be_read_is_said_at_its_line(tmp_path: Path) -> None:
    path = shown(tmp_path)
    (log,) = tmp_path.rglob("*_ED.owl")
    log.write_text(log.read_text()[:2000])
    done = cramlite("check", path)
    assert done.returncode == 2 and f"{path}:7: the demonstration cannot be used: {log}" in done.stderr, done.stderr


def test_a_scenario_without_things_for_what_was_shown_is_said(tmp_path: Path) -> None:
    basket, at = "model: basket\n    at: {position: [0.30, -0.45, 0", "model: can\n    at: {position: [0.30, -0.45, 60 mm"
    done = cramlite("check", shown(tmp_path, basket, at))
    assert done.returncode == 2 and f"{tmp_path}/mine.yaml:7: the scenario has no things for the demonstration" in done.stderr
    assert "cram:Basket" in done.stderr or "Cavity" in done.stderr, done.stderr


def test_a_rule_that_is_wrong_is_explained_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text((ROOT / "task_rules" / "grasping.yaml").read_text().replace("grasps(", "graspz("))
    done = cramlite("check", path)
    assert done.returncode == 2 and "graspz" in done.stderr and f"{path}:" in done.stderr


def test_doubts_about_a_program_have_their_lines(tmp_path: Path) -> None:
    path = tmp_path / "p.script"
    path.write_text(BAD_PROGRAM)
    done = cramlite("check", path)
    assert done.returncode == 0, done.stderr
    wanted = {
        2: "degrees", 3: "millimetres", 4: "degrees", 5: "time-out", 8: "a string", 9: "condition", 13: "never reached",
    }  # fmt: skip
    for line, said in wanted.items():
        assert any(f":{line}: " in x and said in x for x in done.stdout.splitlines()), (line, said, done.stdout)


def test_a_program_that_calls_what_there_is_not_fails(tmp_path: Path) -> None:
    path = tmp_path / "p.script"
    path.write_text("def p():\n  mooveJ([0])\nend\n")
    done = cramlite("check", path)
    assert done.returncode == 2 and f"{path}: URScript, line 2" in done.stderr and "mooveJ" in done.stderr


def test_an_ontology_is_sent_to_its_own_check() -> None:
    done = cramlite("check", ROOT / "ontologies" / "tasks.ttl")
    assert done.returncode == 2 and "ontology check" in done.stderr


UNSAFE = """def p():
  def again(n):
    return again(n - 1)
  end
  movel(p[0.5, 0, 0.3, 0, 3.14, 0], a=1.2, v=250)
  movej([0, -1, 1, 0, 0, 0], 1.4, 60)
  force_mode(p[0, 0, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [0, 0, 5, 0, 0, 0], 2, [0.1, 0.1, 0.1, 0.1, 0.1, 0.1])
  again(3)
end
"""


def test_check_doubts_speeds_recursion_and_force_mode_that_is_left_on(tmp_path: Path) -> None:
    path = tmp_path / "unsafe.script"
    path.write_text(UNSAFE)
    said = cramlite("check", path).stdout
    for line, words in ((2, "'again' calls itself"), (5, "250 m/s"), (6, "60 rad/s"), (7, "nowhere off")):
        assert any(x.startswith(f"{path}:{line}:") and words in x for x in said.splitlines()), said
    sound = UNSAFE
    for old, new in (("  again(3)", "  end_force_mode()"), ("again(n - 1)", "n"), ("250", "0.25"), ("60", "1")):
        sound = sound.replace(old, new)
    path.write_text(sound)
    assert "no doubts" in cramlite("check", path).stdout


BLOCK = """\
scenario: block
tasks: [{task: Grasping, Patient: block}]
robot: {type: ur5e}
things:
  - name: block
    model: block
    at: {position: [0.5, 0.2, 51 mm]}
    with:
      size: [50 mm, 50 mm, 100 mm]
      mass: 0.1 kg
"""


@pytest.mark.parametrize(
    ("old", "new", "line", "says"),
    [
        ("0.1 kg", "3 mm", 10, "thing 'block': parameter 'mass' is '3 mm'"),
        ("mass:", "mas:", 10, "no parameter 'mas'; did you mean 'mass'?"),
        ("[50 mm, 50 mm, 100 mm]", "50 mm", 9, "parameter 'size' is '50 mm': 3 values are needed, in a list"),
        ("[50 mm, 50 mm, 100 mm]", "[50 mm, 100 mm]", 9, "parameter 'size' is ('50 mm', '100 mm'): 3 values are needed"),
        ("    at: {position: [0.5, 0.2, 51 mm]}\n", "", 5, "the first thing 'block': a thing needs exactly one of 'at' and 'hangs_on'"),
        ("type: ur5e", "type: ur5E", 3, "no robot 'ur5E'; did you mean 'ur5e'?"),
        ("model: block", "model: blok", 5, "no object model 'blok'; did you mean 'block'"),
    ],
)
def test_a_wrong_parameter_has_its_own_line(old: str, new: str, line: int, says: str, tmp_path: Path, run: Run) -> None:
    path = tmp_path / "block.yaml"
    path.write_text(BLOCK)
    assert run("check", path).code == 0
    path.write_text(BLOCK.replace(old, new))
    ran = run("check", path)
    assert ran.code == 2
    assert f"{path}:{line}: " in ran.err and says in ran.err


@pytest.mark.parametrize("name", ["place_on_shelf", "block"])
def test_a_name_of_thousands_of_characters_is_refused_in_a_short_paragraph(tmp_path: Path, name: str) -> None:
    text, path = (ROOT / "scenarios" / "place_on_shelf.yaml").read_text(), tmp_path / "mine.yaml"
    path.write_text(re.sub(rf"(?<!model: )\b{name}\b", "a" * 4000, text))
    done = cramlite("check", path)
    assert done.returncode == 2 and "has 4000 characters, and at most 100 should be in it" in done.stderr, done.stderr[:500]
    assert len(done.stderr) < 600 and not done.stdout, done.stderr[:1000]
    path.write_text(re.sub(rf"(?<!model: )\b{name}\b", "a" * 100, text))
    assert cramlite("check", path).returncode == 0
