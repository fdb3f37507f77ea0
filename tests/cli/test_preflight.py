"""``cramlite preflight``: the speeds and forces of a program are measured, and each one beyond a limit is named."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from conftest import Run

from cramlite.cli.main import main


@pytest.fixture(scope="module")
def taken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run directory of a pouch that was taken off its hook, tried in one twin."""
    folder = tmp_path_factory.mktemp("preflight") / "taken"
    assert main(["resolve", "grasp_one_thing", "--twins", "1", "--no-report", "--out", str(folder)]) == 0
    return folder


@pytest.mark.heavy
def test_the_page_of_a_run_has_all_its_parts(run: Run, taken: Path) -> None:
    done = run("preflight", taken)
    assert done.code == 0, done.err
    for part in ("SET ON THE CONTROLLER of the ur5e", "SAFETY LIMITS", "PUT EVERYTHING", "THE MODEL LEAVES OUT", "DOUBTS THAT", "DID NOT"):
        assert part in done.out
    assert "payload            0.925 kg" in done.out and "up to 1.225 kg (1.Grasping/payload)" in done.out
    assert "NO" not in done.out.replace("NOT", "") and "coffee" in done.out
    assert max(map(len, done.out.splitlines())) < 140


@pytest.mark.heavy
def test_numbers_are_those_of_the_run_and_of_its_twins(run: Run, taken: Path) -> None:
    found = json.loads(run("preflight", taken, "--json").out)
    force = next(c for c in found["checks"] if c["name"] == "tool force")
    findings = json.loads((taken / "verdict.json").read_text())
    peak = next(f for f in findings["findings"] if f["validator"] == "force_peak")
    assert force["reaches"] == pytest.approx(peak["value"], rel=0.01)
    assert force["in_twins"] == max(t["peaks"]["force"] for t in findings["twins"]["twins"])
    assert force["limit"] == 60.0
    assert max(force["reaches"], force["in_twins"]) < force["set"] <= force["limit"]
    assert set(found["covered"]) == {d["source"] for t in findings["twins"]["twins"] for d in t["draws"]}
    assert "hand-eye" in found["not_covered"] and found["ready"]


@pytest.mark.parametrize(
    ("limit", "says"),
    [
        ("tool_speed=0.05", "tool speed 0."), ("tool-force=0.5", "tool force "), ("joint_speed=20", "joint speed wrist_1 "),
        ("payload=1", "payload 1.23 kg exceeds 1 kg (yours)"),
    ],
)  # fmt: skip
def test_what_exceeds_a_limit_is_said_and_the_program_not_ready(run: Run, taken: Path, limit: str, says: str) -> None:
    done = run("preflight", taken, "--limit", limit)
    assert done.code == 1
    assert "NOT READY" in done.out and f"  NO  {says}" in done.out
    assert says in done.err and done.err.count("\n") == 1


def test_a_dry_run_is_slower_and_judged(run: Run, taken: Path, tmp_path: Path) -> None:
    slow = tmp_path / "slow.script"
    usual = json.loads(run("preflight", taken, "--json").out)["checks"][0]
    done = run("preflight", taken, "--speed", "0.5", "--out", slow, "--json")
    assert done.code == 0, done.err
    found = json.loads(done.out)
    assert found["speed"] == 0.5
    assert found["checks"][0]["reaches"] == pytest.approx(usual["reaches"] / 2, rel=0.05)
    assert found["checks"][0]["in_twins"] is None
    assert slow.read_text() != (taken / "program.script").read_text()
    text = run("preflight", slow, "--world", "grasp_one_thing")
    assert text.code == 0 and "Not proven: this text" in text.out and "none: nothing was proven" in text.out
    assert "up to 1.225 kg" not in text.out and "PUT EVERYTHING" not in text.out


def test_an_altered_text_is_not_taken_for_the_proven_one(run: Run, taken: Path, tmp_path: Path) -> None:
    altered = tmp_path / "altered"
    shutil.copytree(taken, altered)
    text = altered / "program.script"
    text.write_text(text.read_text().replace("v=", "v=2*", 1))
    done = run("preflight", altered)
    assert (done.code, done.out) == (2, "") and "differs from the text that was proven" in done.err
    text.unlink()
    assert run("preflight", altered).code == 2


def test_a_text_that_stops_is_not_ready(run: Run, tmp_path: Path) -> None:
    text = tmp_path / "stops.script"
    text.write_text('def p():\n  popup("no part", error=True, blocking=True)\n  halt\nend\n')
    done = run("preflight", text, "--world", "grasp_one_thing")
    assert done.code == 1 and "the text ended by halted" in done.err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("nowhere",), "'nowhere' cannot be read"),
        (("TAKEN/program.script",), "does not say in which world it runs"),
        (("TAKEN/program.script", "--world", "grasp_one_thing", "--speed", "0.2"), "only a typed program can be written anew"),
        (("TAKEN", "--speed", "0"), "above 0 and up to 1"),
        (("TAKEN", "--speed", "nan"), "above 0 and up to 1"),
        (("TAKEN", "--out", "x"), "give its speed"),
        (("TAKEN", "--limit", "power=80"), "there is no limit 'power'"),
        (("TAKEN", "--limit", "tool_speed=fast"), "is no number above 0"),
        (("TAKEN/..",), "does not say what its program is for"),
    ],
)
def test_bad_input_is_one_paragraph(run: Run, taken: Path, arguments: tuple[str, ...], says: str) -> None:
    done = run("preflight", *(a.replace("TAKEN", str(taken)) for a in arguments))
    assert (done.code, done.out, done.err.count("\n")) == (2, "", 1)
    assert says in done.err
