"""The table of capabilities: what the backend writes fits the controller, what does not is refused, the docs say the same."""

from __future__ import annotations

import pytest
from conftest import ROOT
from msgspec.structs import replace
from test_urscript import STEPS, program

from cramlite.plugin import UserError
from cramlite_plugins.backends.urscript import emit as urscript
from cramlite_plugins.backends.urscript.controllers import CAPABILITIES, CB3, E_SERIES, X, controller_of, lacking
from cramlite_plugins.robots.ur5 import UR5
from cramlite_plugins.robots.ur5e import UR5E


def test_what_the_backend_writes_is_what_the_controller_has() -> None:
    for robot in (UR5E, UR5):
        text = urscript.emit(replace(program(*STEPS), robot_type=robot.type), robot).text
        assert list(lacking(text, *controller_of(robot))) == []


def test_an_e_series_program_is_not_one_for_cb3_and_says_why() -> None:
    text = urscript.emit(program(*STEPS), UR5E).text
    found = " ".join(lacking(text, CB3, "3.15"))
    assert "CB3 does not have zero_ftsensor" in found and "CB3 does not have set_target_payload" in found
    assert "set_target_payload needs PolyScope 5.10 on e-Series, not 5.9" in " ".join(lacking(text, E_SERIES, "5.9"))
    assert "PolyScope X is not known to have set_target_payload" in " ".join(lacking(text, X, "10.7"))
    assert "force_mode needs PolyScope 10.7 on PolyScope X, not 10.6" in " ".join(lacking("  force_mode()", X, "10.6"))


def test_the_backend_refuses_what_the_controller_lacks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(urscript, "controller_of", lambda _: (E_SERIES, "5.9"))
    with pytest.raises(UserError, match=r"needs PolyScope 5\.10"):
        urscript.emit(program(*STEPS), UR5E)


def test_comments_are_no_calls() -> None:
    assert list(lacking("# tool_contact(1)\n", CB3, "3.15")) == []


def test_the_docs_have_the_same_table() -> None:
    page = (ROOT / "docs" / "reference" / "robot_code.md").read_text()
    for c in CAPABILITIES:
        assert f"| `{c.function}` | {c.cb3 or 'no'} | {c.e_series or 'no'} | {c.polyscope_x} | {c.source} |" in page
