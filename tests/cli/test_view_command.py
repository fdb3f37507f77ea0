"""The interactive viewer: the real library serves a real run, and its slider moves the bodies."""

from __future__ import annotations

import importlib.util
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from conftest import Run
from helpers.headless import Browser, chromium

from cramlite.cli.main import main
from cramlite.cli.program_input import program_of, recorded
from cramlite.cli.view import free_port, no_browser, require_viser, viewer_of
from cramlite.plugin import UserError
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.registry import Registry

if TYPE_CHECKING:
    from cramlite.cli.viewer import Viewer

pytest.importorskip("viser", reason="the extra cramlite[view] is not installed")

TURN = """def turn():
  movej([2.0, -1.6, 1.6, -1.4, -1.57, 1.2], a=1.4, v=1.05)
end
turn()
"""
WRIST, BASE = "arm/wrist_3_link", "arm/base_link"


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a short run."""
    folder = tmp_path_factory.mktemp("ran")
    (folder / "turn.script").write_text(TURN)
    main(["execute", str(folder / "turn.script"), "--world", "grasp_one_thing", "--out", str(folder / "run"), "--no-episode"])
    (folder / "run" / "program.script").write_text(TURN)
    return folder / "run"


@pytest.fixture(scope="module")
def viewer(ran: Path) -> Iterator[Viewer]:
    knowledge = Knowledge(Registry())
    rollout = recorded(ran, None, knowledge)
    made = viewer_of(rollout, knowledge, program_of(ran), "127.0.0.1", free_port("127.0.0.1", 18080))
    yield made
    made.close()


def test_the_server_is_up(viewer: Viewer) -> None:
    with urllib.request.urlopen(viewer.url, timeout=20) as answer:
        assert answer.status == 200
        assert b"<html" in answer.read().lower()


def test_the_scene_holds_the_links_and_things(viewer: Viewer) -> None:
    names = {
        "base_link",
        "shoulder_link",
        "upper_arm_link",
        "forearm_link",
        "wrist_1_link",
        "wrist_2_link",
        "wrist_3_link",
    }
    assert {f"arm/{n}" for n in names} | {"hook", "coffee"} <= set(viewer.bodies)
    for body, frame in viewer.bodies.items():
        assert frame.name.endswith(body.rpartition("/")[2])


def test_the_slider_moves_the_links(viewer: Viewer) -> None:
    wrist, base = viewer.bodies[WRIST], viewer.bodies[BASE]
    start, foot = wrist.position.copy(), base.position.copy()
    viewer.slider.value = 1.0
    assert viewer.position == 25
    assert np.linalg.norm(wrist.position - start) > 0.05
    assert base.position == pytest.approx(foot)
    assert "movej" in viewer.words.content
    viewer.slider.value = 0.0
    assert wrist.position == pytest.approx(start)


def test_play_goes_on_from_where_it_is(viewer: Viewer) -> None:
    viewer.slider.value = 0.0
    viewer.play(0.1)
    assert viewer.position == 0
    viewer.playing.value, viewer.speed.value = True, "4"
    viewer.play(0.5)
    assert viewer.position > 0
    viewer.playing.value = False


@pytest.mark.skipif(chromium() is None, reason="there is no Chromium")
def test_a_person_in_a_browser_moves_it(viewer: Viewer) -> None:
    viewer.slider.value = 0.0
    start = viewer.bodies[WRIST].position.copy()
    with Browser(chromium() or "", "--enable-unsafe-swiftshader") as browser:
        browser.look(420, 320)  # small: the machine may have no graphics card
        browser.open(viewer.url)
        browser.wait("document.querySelector('[role=slider]') !== null && document.querySelector('canvas') !== null")
        browser.run("document.querySelector('[role=slider]').focus()")
        browser.press("ArrowRight", 20)
        browser.wait("+document.querySelector('[role=slider]').getAttribute('aria-valuenow') >= 0.79")
        end = time.monotonic() + 60
        while viewer.position != 20 and time.monotonic() < end:
            time.sleep(0.1)
    assert viewer.position == 20
    assert np.linalg.norm(viewer.bodies[WRIST].position - start) > 0.02


def test_without_a_browser_it_says_what_to_do(ran: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    done = run("view", ran, "--seconds", 0.1, "--port", 18180)
    assert done.code == 0
    assert "The viewer is at http://127.0.0.1:18180" in done.out
    assert done.err.strip() == no_browser("http://127.0.0.1:18180")
    quiet = run("view", ran, "--seconds", 0.1, "--port", 18180, "--no-browser")
    assert quiet.code == 0 and quiet.err == ""
    assert quiet.out.count("\n") == 1


def test_without_the_extra_it_says_how_to_install_it(ran: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    require_viser()
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *a: None if name == "viser" else find(name, *a))
    done = run("view", ran)
    assert done.code == 2
    assert "pip install 'cramlite[view]'" in done.err and "report.html" in done.err
    assert done.err.count("\n") == 1


def test_what_is_no_run_is_explained(ran: Path, tmp_path: Path, run: Run) -> None:
    assert "holds no recorded run" in run("view", tmp_path).err
    (tmp_path / "rollout.npz").write_bytes((ran / "rollout.npz").read_bytes())
    assert "give it with --world" in run("view", tmp_path).err
    assert "was not in this world" in run("view", tmp_path, "--world", "place_on_shelf").err
    (tmp_path / "rollout.npz").write_bytes(b"PK half of it")
    done = run("view", tmp_path, "--world", "grasp_one_thing")
    assert done.code == 2 and "holds no recorded run" in done.err


def test_an_address_that_cannot_be_served_is_explained() -> None:
    with pytest.raises(UserError, match=r"Nothing can be served at 203\.0\.113\.1:8080"):
        free_port("203.0.113.1", 8080)
    with pytest.raises(UserError, match="no port is free"):
        free_port("127.0.0.1", 70000)
