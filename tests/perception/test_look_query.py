"""What ``cramlite perceive --query`` takes a scenario's ``camera.queries`` takes too: one parser, and the experts that are loaded."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import Run

from cramlite import Engine, find_scenario, read_scenario
from cramlite.plugin import UserError

SCENARIO = "fetch_from_hanger_camera"
BRIGHT = """
from cramlite.plugin import Expert, Judged, hookimpl

def brightness(inputs):
    mean = float(inputs["view"].rgb[inputs["segment"].mask].mean())
    return {"brightness": Judged("bright" if mean > 85 else "dark", 0.9, f"{mean:.0f} of 255")}

@hookimpl
def experts():
    return [Expert("mean_brightness", "whether it is bright", ("view", "segment"), ("brightness",), brightness, "object",
                   domains={"brightness": ("bright", "dark")})]
"""
QUERY = "brightness=bright on=Hanger"


@pytest.fixture
def bright(tmp_path: Path) -> Path:
    path = tmp_path / "bright.py"
    path.write_text(BRIGHT)
    return path


def told(folder: Path, query: str, *, poses: str = "camera") -> Path:
    """The shipped scenario with a camera that is told what to look for."""
    text = find_scenario(SCENARIO).read_text()
    text = text.replace("  mount: flange\n", f"  mount: flange\n  queries:\n    - {query}\n").replace("poses: camera", f"poses: {poses}")
    assert query in text
    path = folder / "told.yaml"
    path.write_text(text.replace("demonstration: ", f"demonstration: {find_scenario(SCENARIO).parent}/"))
    return path


def line_of(path: Path, query: str) -> int:
    return next(k for k, line in enumerate(path.read_text().splitlines(), 1) if query in line)


@pytest.mark.heavy
def test_an_attribute_of_a_plugin_is_looked_for(run: Run, bright: Path, tmp_path: Path) -> None:
    asked = run("perceive", SCENARIO, "--plugin", bright, "--query", QUERY)
    assert asked.code == 0, asked.err
    assert "mean_brightness" in asked.out
    setting = Engine(files=[bright]).setting(read_scenario(told(tmp_path, QUERY)))
    assert setting.look is not None
    (picture,) = setting.look.pictures
    assert picture.perceived is not None
    assert str(picture.perceived.query) == QUERY
    assert picture.perceived.answers[0].value("brightness") == "bright"


@pytest.mark.parametrize(
    ("query", "said"),
    [
        (QUERY, "'brightness=bright': a query cannot ask for 'brightness'; "),
        ("colr=red", "'colr=red': a query cannot ask for 'colr'; did you mean 'color'?"),
        ("type=cram:TeaBxo", "'type=cram:TeaBxo': unknown class 'cram:TeaBxo'; did you mean 'cram:TeaBox'?"),
        ("size>=big", "'size>=big': 'big' is no number"),
        ("red", "'red' is no condition of a query"),
    ],
)
@pytest.mark.parametrize("poses", ["camera", "known"])
def test_both_refuse_what_is_wrong_in_the_same_words(run: Run, tmp_path: Path, poses: str, query: str, said: str) -> None:
    asked = run("perceive", SCENARIO, "--query", query)
    assert asked.code == 2 and said in asked.err
    path = told(tmp_path, query, poses=poses)
    checked = run("check", path)
    assert checked.code == 2 and f"{path}:{line_of(path, query)}: {said}" in checked.err


def test_an_attribute_goes_with_its_expert(tmp_path: Path) -> None:
    """What a blocked expert would say cannot be asked for."""
    scenario, engine = read_scenario(told(tmp_path, "material=foil")), Engine()
    (owner,) = {engine.knowledge.expert_owners[e.name] for e in engine.knowledge.experts if "material" in e.outputs}
    with pytest.raises(UserError, match="cannot ask for 'material'"):
        Engine(blocked=[owner]).setting(scenario)
