"""The command line: what it imports, what it prints."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from conftest import ROOT, TASKS, Run

DEMONSTRATION = ROOT / "scenarios" / "fetch_from_hanger" / "demonstration"
STAGES = [
    f"cramlite.{m}"
    for m in (
        "scenario.scenario", "planning.task_goals", "planning.search.search", "engine.proof.proof", "engine.late_poses", "scenario.worlds",
        "cli.resolve", "cli.run_files",
    )
]  # fmt: skip
"""What comes after interpretation."""
PROVEN = [f"cramlite.{m}" for m in ("engine.proof.proof", "engine.late_poses", "engine.candidates")]
"""What a scenario needs only when it is resolved."""
READ = [f"cramlite.{m}" for m in ("interpretation.interpretation", "interpretation.decision_tree")]
"""What only a scenario that starts from a demonstration needs."""
UNASKED = ["glfw", "asyncio", "numpy.random", "cramlite_plugins.simulation.controller.controller"]
"""What no check has a use for, though the plugins that do are loaded."""
IMPORTED = """
import sys
from cramlite.cli.main import main
try: main({arguments!r})
except SystemExit: pass
print("IMPORTED", *[m for m in {heavy!r} if m in sys.modules])
"""


@pytest.mark.parametrize(
    ("arguments", "heavy"),
    [
        (["--help"], ["mujoco", "ompl", "rdflib", "scipy", "pydantic", "numpy", "pluggy.__none__", "yaml"]),
        (["tasks"], ["mujoco", "ompl", "rdflib", "scipy", "matplotlib", "jinja2", "pydantic", "cramlite.engine.engine"]),
        (["interpret", str(DEMONSTRATION)], ["mujoco", "ompl", "scipy", "matplotlib", "pydantic", *STAGES]),
        (
            ["check", str(ROOT / "scenarios" / "place_on_shelf.yaml")],
            ["ompl", "rdflib", "scipy", "matplotlib", "jinja2", *PROVEN, *READ, *UNASKED],
        ),
        (["check", str(ROOT / "scenarios" / "fetch_from_hanger.yaml")], ["ompl", "scipy", "matplotlib", "jinja2", *PROVEN, *UNASKED]),
    ],
)
def test_light_commands_import_no_heavy_library(arguments: list[str], heavy: list[str]) -> None:
    script = IMPORTED.format(arguments=arguments, heavy=heavy)
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert out.strip().splitlines()[-1] == "IMPORTED"


def test_the_check_of_imports_sees_an_import() -> None:
    script = IMPORTED.format(arguments=["plugins"], heavy=["pluggy"])
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert out.strip().splitlines()[-1] == "IMPORTED pluggy"


@pytest.mark.parametrize(("arguments", "code"), [(["--version"], 0), (["check", "no_such_scenario"], 2)])
def test_the_package_runs_as_a_module_as_its_script_does(arguments: list[str], code: int) -> None:
    done = subprocess.run([sys.executable, "-m", "cramlite", *arguments], capture_output=True, text=True, check=False)
    (script,) = entry_points(group="console_scripts", name="cramlite")
    words = [sys.executable, "-c", f"import sys; from {script.module} import {script.attr}; sys.exit({script.attr}())", *arguments]
    same = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == same.returncode == code
    assert (done.stdout, done.stderr) == (same.stdout, same.stderr) != ("", "")


def test_tasks(run: Run) -> None:
    assert "soma:Grasping(Patient or object)" in run("tasks").out
    rows = json.loads(run("tasks", "--json").out)
    grasping = next(r for r in rows if r["task"] == "soma:Grasping")
    assert grasping["roles"][0]["name"] == "Patient"
    assert all(p["source"] for r in rows for p in r["parameters"])
    assert "soma:Grasping" not in run("tasks", "--block", "grasping").out


def test_plugins(run: Run) -> None:
    rows = json.loads(run("plugins", "--json").out)
    assert {"name", "distribution", "version", "file", "hooks", "load_ms", "fault"} <= set(rows[0])
    every, short = run("plugins", "--all").out, run("plugins").out
    assert "grasping (cramlite" in every and "grasping (cramlite" not in short
    assert all(re.search(rf"[ ,]{r['name']}[,\n]", short) for r in rows)
    assert f"{len(rows)} plugins of cramlite" in short
    assert len(short.splitlines()) < 40 < len(every.splitlines())


def test_interpret(run: Run) -> None:
    found = json.loads(run("interpret", DEMONSTRATION, "--json").out)
    assert found["actions"]
    assert " readings" in run("interpret", DEMONSTRATION).out
    why = run("interpret", DEMONSTRATION, "--why", "Grasping@0")
    assert why.code == 0
    assert "Grasping" in why.out


@pytest.mark.parametrize("why", ["Grasping", "Grasping@", "Grasping@x", "Grasping@99", "Graspin@0", "@0", "Grasping@-1"])
def test_why_of_what_is_not_there(why: str, run: Run) -> None:
    ran = run("interpret", DEMONSTRATION, "--why", why)
    assert ran.code == 2, ran.err
    assert ran.err.startswith("cramlite: ")
    assert "Traceback" not in ran.err


KEYS = [
    "solved", "proven", "headline", "execution", "directory", "seed", "candidate", "plan", "objects", "steps", "findings", "advice",
    "left_out", "twins", "goal", "reason", "nearest", "try", "faults",
]  # fmt: skip


def test_json_of_what_was_not_solved(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "short.yaml"
    path.write_text(TASKS.read_text() + "budget: {expansions: 2}\n")
    ran = run("resolve", path, "--no-report", "--out", tmp_path / "run", "--json")
    assert ran.code == 1 and "expansions = 2" in ran.err
    said = json.loads(ran.out)
    assert said["solved"] is False and "expansions = 2" in said["reason"]
    assert list(said) == KEYS


def test_a_run_is_explained_and_not_overwritten(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "run"
    solved = run("resolve", TASKS, "--no-report", "--out", out, "--json")
    assert solved.code == 0
    said = json.loads(solved.out)
    assert list(said) == KEYS
    assert said["solved"] is True and said["plan"] and not said["nearest"]
    assert json.loads(run("resolve", TASKS, "--no-report", "--out", out, "--json").out) == said
    assert (out / "program.script").is_file()
    assert "Grasping" in run("explain", out).out
    grasp = run("explain", out, "grasp(tea)")
    assert "grasp(tea)" in grasp.out
    assert "in of basket" not in grasp.out  # decisions about the basket are its own
    assert json.loads(run("explain", out, "tea", "--json").out)
    wrong = run("explain", out, "coffee")
    assert wrong.code == 2
    assert "there are: " in wrong.err
    assert "complete" in run("resolve", TASKS, "--no-report", "--out", out).err
    other = run("resolve", TASKS, "--no-report", "--out", out, "--seed", "4")
    assert other.code == 2
    assert "another run (different: seed)" in other.err


def test_explain_of_no_run(run: Run, tmp_path: Path) -> None:
    ran = run("explain", tmp_path)
    assert ran.code == 2
    assert "There is no trace" in ran.err
    (tmp_path / "trace.json").write_text("{")
    assert "damaged" in run("explain", tmp_path).err
    (tmp_path / "trace.json").write_text("[]")
    assert run("explain", tmp_path).code == 2


def test_a_folder_that_holds_something_else_is_left_alone(run: Run, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("important")
    for command in (("resolve", TASKS, "--no-report"), ("record", "fetch_from_hanger")):
        ran = run(*command, "--out", tmp_path)
        assert ran.code == 2
        assert "nothing was written" in ran.err
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


def test_record_needs_something_to_do(run: Run, tmp_path: Path) -> None:
    ran = run("record", "hang_up_a_product", "--out", tmp_path / "neem")
    assert ran.code == 2
    assert "neither a 'record' section nor 'tasks'" in ran.err


@pytest.mark.parametrize(
    ("tasks", "says"),
    [
        ("Graspin block", "did you mean 'Grasping'?"),
        ("Grasping brick", "did you mean 'block'?"),
        ("Grasping block floor", "has the roles Patient; put a comma between two tasks"),
        ("Navigating block", "The simulated person can show: AssumingArmPose"),
        ("Pouring block block", "has no opening (cram:Cavity)"),
        (" , ", "names no task"),
        ("Placing block", "needs a filler for its role 'Relatum'"),
        ("Grasping floor", "finds no grasp of 'floor'"),
    ],
)
def test_what_cannot_be_shown_is_refused(run: Run, tmp_path: Path, tasks: str, says: str) -> None:
    ran = run("record", "tasks/grasping", "--tasks", tasks, "--out", tmp_path / "neem")
    assert ran.code == 2
    assert says in ran.err
    assert "Traceback" not in ran.err and not (tmp_path / "neem").exists()


@pytest.mark.parametrize(
    ("words", "says", "meant"),
    [
        (("resolve", "x", "--sed=3"), "there is no option '--sed'", "did you mean '--seed'?"),
        (("tasks", "--jsn"), "there is no option '--jsn'", "did you mean '--json'?"),
        (("resolve", "x", "--budget", "3"), "there is no option '--budget'", ""),
        (("reslove", "x"), "invalid choice: 'reslove'", "did you mean 'resolve'?"),
        (("schema", "scenarios"), "invalid choice: 'scenarios'", "did you mean 'scenario'?"),
        (("tasks", "extra"), "unrecognized arguments: extra", ""),
    ],
)
def test_wrong_words_on_the_command_line(words: tuple[str, ...], says: str, meant: str, run: Run) -> None:
    ran = run(*words)
    assert ran.code == 2 and ran.out == ""
    assert says in ran.err
    assert meant in ran.err if meant else "did you mean" not in ran.err


@pytest.mark.parametrize("name", [*STAGES, *PROVEN, *READ, *UNASKED])
def test_what_may_not_be_imported_is_there(name: str) -> None:
    """A module that was renamed is never imported by its old name."""
    assert importlib.util.find_spec(name) is not None
