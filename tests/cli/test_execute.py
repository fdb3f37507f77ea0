"""``cramlite execute``: a text and a world."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from subprocess import CompletedProcess

import pytest
from helpers.as_a_user import cramlite

SHORT = """def p():
  movej([0.0, -1.4, 1.4, -1.57, -1.57, 0.0], a=1.4, v=1.05)
  textmsg("there")
end
p()
"""


def execute(*words: object) -> CompletedProcess[str]:
    return cramlite("execute", *words)


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "short.script"
    path.write_text(SHORT)
    return path


def test_a_text_runs_in_the_world_of_a_scenario(program: Path, tmp_path: Path) -> None:
    done = execute(program, "--world", "grasp_one_thing", "--out", tmp_path / "out", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["outcome"] == "finished" and [m["text"] for m in said["messages"]] == ["there"]
    assert json.loads((tmp_path / "out" / "execution.json").read_text()) == said
    assert any((tmp_path / "out" / "episode").iterdir())
    again = execute(program, "--world", tmp_path / "out", "--json")
    assert again.returncode == 0 and json.loads(again.stdout)["poses"].keys() == said["poses"].keys()


def test_a_program_that_stops_fails_with_its_own_words(program: Path) -> None:
    program.write_text(SHORT.replace('textmsg("there")', 'textmsg("cramlite abort: no product")\n  halt'))
    done = execute(program, "--world", "grasp_one_thing")
    assert done.returncode == 1 and "no product" in done.stderr


@pytest.mark.parametrize(
    ("text", "world", "said"),
    [
        (SHORT.replace("end\n", ""), "grasp_one_thing", "end"),
        (SHORT, "no_such_scenario", "no_such_scenario"),
        (SHORT, "BROKEN.json", "holds no world"),
        (SHORT, "missing.json", "cannot be read"),
        (SHORT, "FOLDER", "is a folder that holds no world.json"),
        (SHORT.replace("movej", "moovej"), "grasp_one_thing", "p.script: URScript, line 2: there is no function"),
        (None, "grasp_one_thing", "cannot be read"),
        ("\x00\ufffd".encode("utf-16"), "grasp_one_thing", "no text"),
        (gzip.compress(b"<URProgram/>", mtime=0), "grasp_one_thing", "compressed, as PolyScope's .urp is"),
    ],
)
def test_what_cannot_be_used_is_explained(tmp_path: Path, text: str | bytes | None, world: str, said: str) -> None:
    program, broken = tmp_path / "p.script", tmp_path / "BROKEN.json"
    broken.write_text('{"things": 3}')
    if text is not None:
        program.write_bytes(text if isinstance(text, bytes) else text.encode())
    places = {"BROKEN.json": broken, "FOLDER": tmp_path}
    done = execute(program, "--world", places.get(world, world))
    assert done.returncode == 2 and said in done.stderr and "Traceback" not in done.stderr


def test_nothing_is_overwritten(program: Path, tmp_path: Path) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine").write_text("")
    done = execute(program, "--world", "grasp_one_thing", "--out", tmp_path / "full")
    assert done.returncode == 2 and "not an empty folder" in done.stderr
