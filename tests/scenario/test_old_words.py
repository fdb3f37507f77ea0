"""Words of older files and scripts are refused in one paragraph that says where they stand and what they are called now."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import ROOT, Run

from cramlite import Engine, read_scenario
from cramlite.experiment.demonstrations.spec import read_experiment
from cramlite.experiment.experiment_file import old_keys
from cramlite.model import Fallback, Program, Wait, write_program
from cramlite.plugin import UserError
from cramlite_plugins.robots.ur5e import UR5E

HEAD = "scenario: old\nrobot: {type: ur5e}\nthings: []\n"


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("tasks:\n  - ParkArms\n  - try_in_order: [ParkArms, ParkArms]\n", 6, "the rule 'try_in_order' is called 'choose' where"),
        ("tasks:\n  - try_in_order: {at: run, do: [ParkArms]}\n", 5, "'fallback' where the program decides while it runs"),
        ("tasks:\n  - choose: {at: run, do: [ParkArms]}\n", 5, "'choose' has no 'at'; valid are: do"),
        ("tasks: [ParkArms]\ncamera:\n  fov: 60 deg\n", 6, "unknown key 'fov'; it is called 'horizontal_fov' now"),
        ("tasks: [ParkArms]\ncamera:\n  look: [type=cram:Tin]\n", 6, "unknown key 'look'; it is called 'queries' now"),
        ("tasks: [ParkArms]\nbudget:\n  asks: 3\n", 6, "no budget 'asks'; it is called 'expansions' now"),
    ],
)
def test_an_old_word_of_a_scenario_is_refused(text: str, line: int, said: str, tmp_path: Path) -> None:
    path = tmp_path / "old.yaml"
    path.write_text(HEAD + text)
    with pytest.raises(UserError) as caught:
        Engine().setting(read_scenario(path))
    assert str(caught.value).startswith(f"{path}:{line}: ")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("key", "value"), [("look", "[]"), ("fov", "1")])
def test_a_word_that_was_right_elsewhere_gets_the_names_that_are_right_here(key: str, value: str, tmp_path: Path) -> None:
    path = tmp_path / "old.yaml"
    path.write_text(f"{HEAD}tasks: [ParkArms]\n{key}: {value}\n")
    with pytest.raises(UserError, match=f":5: unknown key '{key}'; (did you mean|valid are)"):
        read_scenario(path)


@pytest.mark.parametrize(
    ("key", "said"), [("asks", "it is called 'expansions' now"), ("prooofs", "did you mean 'proofs'")]
)
def test_a_wrong_budget_of_an_experiment_is_refused(key: str, said: str, tmp_path: Path) -> None:
    text = (ROOT / "experiments/fetch_from_hanger/experiment.yaml").read_text()
    path = tmp_path / "experiment.yaml"
    path.write_text(text.replace("expansions: 400", f"{key}: 400"))
    line = next(k for k, one in enumerate(text.splitlines(), 1) if "expansions: 400" in one)
    with pytest.raises(UserError, match=f"experiment.yaml:{line}: no budget '{key}'; {said}"):
        read_experiment(path)


def test_an_old_step_of_a_typed_program_is_refused(tmp_path: Path, run: Run) -> None:
    steps = (Fallback(((Wait(1.0),), (Wait(2.0),)), origin="any"),)
    typed = Program("p", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, steps, (), mass=0.925, center=(0, 0, 0.05))
    text, path = write_program(typed), tmp_path / "old.json"
    path.write_text(text)
    assert run("check", path).code == 0
    path.write_text(text.replace('"Fallback"', '"TryInOrder"'))
    line = next(k for k, one in enumerate(text.splitlines(), 1) if '"Fallback"' in one)
    ran = run("check", path)
    assert ran.code == 2
    assert f"{path}: The program, line {line}: " in ran.err
    assert "is \"TryInOrder\"; it should be 'Fallback', as it is called now" in ran.err


def test_an_old_option_is_refused(run: Run) -> None:
    ran = run("perceive", "fetch_from_hanger_camera", "--wants=type")
    assert ran.code == 2
    assert "the option '--wants' is called '--attributes' now" in ran.err


def test_old_words_of_an_experiment_are_read_with_a_warning(tmp_path: Path, run: Run) -> None:
    """The message shows that key and option are read: the environment is looked for where the option says."""
    folder, path = ROOT / "experiments/libero", tmp_path / "experiment.yaml"
    path.write_text((folder / "experiment.yaml").read_text().replace("benchmark: conn", f"judge: {folder}/conn"))
    for option in (["--judge", tmp_path / "none"], [f"--judge={tmp_path}/none"]):
        ran = run("experiment", path, "--suite", "libero_90", *option, "--out", tmp_path / "out")
        assert ran.code == 2 and f"there is no '{tmp_path}/none/bin/python'" in ran.err
        assert "warning: the option '--judge' is called '--benchmark' now" in ran.err
        assert f"warning: {path}:3: the key 'judge' is called 'benchmark' now" in ran.err
    new = run("experiment", folder, "--suite", "libero_90", "--benchmark", tmp_path / "none", "--out", tmp_path / "new")
    assert new.code == 2 and f"there is no '{tmp_path}/none/bin/python'" in new.err and "warning" not in new.err


def test_old_validators_of_an_experiment_are_read_and_both_words_refused(tmp_path: Path) -> None:
    text, path = (ROOT / "experiments/fetch_from_hanger/experiment.yaml").read_text(), tmp_path / "experiment.yaml"
    path.write_text(text.replace("validators:", "judges:"))
    assert read_experiment(path).spec == read_experiment(ROOT / "experiments/fetch_from_hanger/experiment.yaml").spec
    line = next(k for k, one in enumerate(text.splitlines(), 1) if one.startswith("validators:"))
    assert old_keys(path) == [f"{path}:{line}: the key 'judges' is called 'validators' now; write that in its place"]
    path.write_text(f"{text}\njudges: [execution]\n")
    with pytest.raises(UserError, match="unknown key 'judges'"):
        read_experiment(path)
