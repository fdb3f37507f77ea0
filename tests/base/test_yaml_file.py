"""YAML as YAML 1.2 says, with lines, and nothing that is no plain value."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ValidationError

from cramlite import find_scenario, read_scenario
from cramlite.base.yaml_file import explain_validation, line_of
from cramlite.plugin import UserError, load_yaml

TEXT = st.text(st.characters(codec="ascii")).filter(lambda t: not re.fullmatch(r"[-+]?[0-9.]+[eE][-+]?[0-9]+|0o[0-7]+", t))
"""PyYAML writes YAML 1.1, to which 0E0 and 0o7 are text."""
SCALARS = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | TEXT
DATA = st.recursive(SCALARS, lambda d: st.lists(d, max_size=4) | st.dictionaries(st.text("abcxyz", max_size=4), d, max_size=4))


def loaded(text: str, folder: Path) -> object:
    (folder / "file.yaml").write_text(text, encoding="utf-8")
    return load_yaml(folder / "file.yaml")


@given(DATA)
def test_what_pyyaml_writes_is_read(tmp_path_factory: pytest.TempPathFactory, data: object) -> None:
    assert loaded(yaml.safe_dump(data), tmp_path_factory.getbasetemp()) == data


CORE = {
    "on": "on", "yes": "yes", "010": 10, "0o17": 15, "0x1F": 31, "1_000": "1_000", "1e3": 1000.0, ".5": 0.5, "-.inf": -float("inf"),
    "~": None, "": None, "TRUE": True, "1:30": "1:30", "2026-01-01": "2026-01-01", "'1'": "1", "!!str 1": "1", "1e": "1e",
}  # fmt: skip


@pytest.mark.parametrize(("written", "meant"), CORE.items())
def test_scalars_are_those_of_yaml_1_2(tmp_path: Path, written: str, meant: object) -> None:
    assert loaded(f"a: {written}", tmp_path) == {"a": meant}


def test_anchors_and_merged_keys(tmp_path: Path) -> None:
    assert loaded("a: &x {k: 1, l: 2}\nb:\n  <<: *x\n  k: 3\nc: *x", tmp_path) == {
        "a": {"k": 1, "l": 2}, "b": {"k": 3, "l": 2}, "c": {"k": 1, "l": 2},
    }  # fmt: skip


def test_lines_of_keys_and_items(tmp_path: Path) -> None:
    data = loaded("# first\na:\n  - b: 1\n    c: {d: 2,\n        e: 3}\n  -\n    f: 4\n", tmp_path)
    places = [((), 2), (("a",), 2), (("a", 0), 3), (("a", 0, "c"), 4), (("a", 0, "c", "e"), 5), (("a", 1, "f"), 7), (("x",), 2)]
    assert [line_of(data, place) for place, _ in places] == [line for _, line in places]
    assert line_of({"plain": [1]}, ["plain", 0]) == 1


BAD = {
    "a: 1\nb: {a: 1, a: 2}": (2, "duplicate key"),
    "a: 1\nb: !!python/object/apply:os.system [ls]": (2, "not allowed"),
    "a: 1\nb: !mine x": (2, "'!mine' is not allowed"),
    "? [1]\n: 2": (1, "as a key"),
    "a: &x [*x]": (1, "recursive"),
    "a: *nobody": (1, "undefined alias"),
    "--- 1\n--- 2": (2, "another document"),
    "a: !!int x": (None, "invalid literal"),
    "a: \x01": (None, "not allowed"),
    "[" * 500: (None, "more than 100 deep"),
    "- " * 500: (None, "more than 100 deep"),
    "a: " + "9" * 5000: (None, "4300 digits"),
}


@pytest.mark.parametrize(("text", "said"), BAD.items(), ids=range(len(BAD)))
def test_what_is_refused(tmp_path: Path, text: str, said: tuple[int | None, str]) -> None:
    line, words = said
    with pytest.raises(UserError, match=rf"file\.yaml{f':{line}' if line else ''}: not valid YAML: .*{words}"):
        loaded(text, tmp_path)


@pytest.mark.parametrize("opening", ["[", "- "])
def test_what_would_overflow_the_stack_is_refused(tmp_path: Path, opening: str) -> None:
    with pytest.raises(UserError, match=r"not valid YAML: .*(more than 100 deep|maximum nesting depth)"):  # ours, libyaml's
        loaded(opening * 100_000, tmp_path)


# Places as a person counts them

THINGS = """\
goal: [a on b, {g}]
things:
  - {{name: floor, at: [1, 2, {x}]}}
  - {{at: [1, 2, 3]}}
  - name: tea
    hangs_on: {{depth: {d}}}
"""


class _Hangs(BaseModel):
    depth: float = 0.0


class _Part(BaseModel):
    name: str
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    hangs_on: _Hangs | None = None


class _Whole(BaseModel):
    goal: list[str]
    things: list[_Part]


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"d": "deep"}, ":6: 'hangs_on.depth' of the third thing 'tea': Input should be"),
        ({"x": "far"}, ":3: the third value of 'at' of the first thing 'floor': Input should be"),
        ({"g": "3"}, ":1: the second value of 'goal': this is a number; it should be text"),
        ({}, ":4: 'name' of the second thing is missing"),
    ],
)
def test_places_are_said_as_people_count(given: dict[str, str], says: str, tmp_path: Path) -> None:
    path = tmp_path / "file.yaml"
    path.write_text(THINGS.format(**{"g": "b on a", "x": "3", "d": "0.1"} | given))
    data = load_yaml(path)
    if not given:
        data["things"][1].pop("name", None)
    else:
        data["things"][1]["name"] = "shelf"
    with pytest.raises(ValidationError) as found:
        _Whole.model_validate(data)
    said = str(explain_validation(path, data, found.value, []))
    assert f"{path}{says}" in said
    assert not re.search(r"\.\d", said.replace(str(path), "")), "nobody counts from 0"


def test_entries_after_the_tenth() -> None:
    with pytest.raises(ValidationError) as found:
        _Whole.model_validate({"goal": ["on"] * 11 + [3], "things": []})
    assert "the 12th value of 'goal'" in str(explain_validation(Path("f"), {"goal": ["on"] * 11 + [3]}, found.value, []))


WRONG = {
    "scenario: x\nrobot: [ur5e]\n": ":2: 'robot': this is a list; it should be a mapping, such as 'key: value'",
    "scenario: x\nrobot: {type: ur5e}\nthings: {a: b}\n": ":3: 'things': this is a mapping; it should be a list",
    "scenario: x\nrobot: {type: true}\n": ":2: 'robot.type': this is true or false; it should be text",
    "scenario:\nrobot: {type: ur5e}\n": ":1: 'scenario': this is empty; it should be text",
    "scenario: x\nrobot: {type: ur5e}\nthings: []\ngoal: []\n": ":4: 'goal': it has no entries, and needs at least 1",
    "scenario: x\nrobot: {type: ur5e}\nthings: []\ngoal: tin on tray\n":
        r":4: 'goal': this is text; a condition is in a list, \[tin on tray\], and a sentence is written {say: tin on tray}",
    "scenario: x\nrobot: {type: ur5e}\nthings: []\ngoal: [3]\n": ":4: the first value of 'goal': this is a number; it should be text\\.$",
    "scenario: x\nrobot: {type: ur5e}\nthings: []\ngoal: [{goal: 'on', things: [{count: true, of: Tin}, a]}]\n":
        ":4: the first goal: in the goal {'count': True, 'of': 'Tin'} is no thing; a thing is given as its name, ",
    "scenario: x\nrobot: {type: ur5e}\nthings: []\ngoal: [a]\nvary: [{thing: a, position: -1}]\n":
        ":5: 'position' of the first vary: Input should be greater than or equal to 0",
    "scenario: x\n\u0085\u2028é": "not valid YAML: ",  # behind the last line: YAML counts other line ends, too
    "scenario: x\nrobot:\n\ttype: ur5e\n": ":3: not valid YAML: .*there is a tab in this line",
}


@pytest.mark.parametrize(("text", "says"), WRONG.items(), ids=range(len(WRONG)))
def test_kinds_are_called_as_in_yaml(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "file.yaml").write_text(text)
    with pytest.raises(UserError, match=says):
        read_scenario(tmp_path / "file.yaml")


@pytest.mark.parametrize(
    ("typed", "meant"), [("kitchn.yaml", "kitchen.yaml"), ("place_on_shlf", "place_on_shelf"), ("sub/kitchn.yaml", "sub/kitchen.yaml")]
)
def test_a_typo_of_a_scenarios_file_proposes_files_of_its_folder(
    typed: str, meant: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in (tmp_path, tmp_path / "sub"):
        folder.mkdir(exist_ok=True)
        (folder / "kitchen.yaml").touch()
    with pytest.raises(UserError, match=f"no scenario file '{typed}'.*did you mean '{meant}'"):
        find_scenario(typed)


def test_a_name_that_no_file_can_have(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be the name of a file"):
        find_scenario("a" * 5000)
