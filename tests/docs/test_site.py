"""The documentation as a site of files: its search works, it loads nothing from elsewhere, and it shows its code whole."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT
from helpers.headless import Browser, chromium

FOUND = "+(document.querySelector('.md-search-result__meta')?.textContent.match(/\\d+/)?.[0] ?? 0)"
TOO_WIDE = "[...document.querySelectorAll('pre > code')].filter(e => e.scrollWidth > e.clientWidth + 1).map(e => e.textContent)"
PAGES = ("index.html", "tutorial/scenario.html", "tutorial/wiping.html", "how-to/task_plugin.html", "reference/hooks.html")
BROWSER = chromium()

pytestmark = pytest.mark.skipif(
    BROWSER is None or importlib.util.find_spec("material") is None, reason="needs Chromium and the extra 'docs'"
)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    path = os.pathsep.join([str(ROOT), str(ROOT / "plugins"), os.environ.get("PYTHONPATH", "")])
    subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", folder],
        cwd=ROOT, check=True, env={**os.environ, "NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": path},
    )  # fmt: skip
    return folder


@pytest.fixture
def browser() -> Iterator[Browser]:
    assert BROWSER is not None
    with Browser(BROWSER) as found:
        yield found


def test_it_is_searched_without_a_server(site: Path, browser: Browser, tmp_path: Path) -> None:
    browser.look(1280)
    browser.open(f"{(site / 'index.html').as_uri()}?q=gripper")
    browser.wait(f"{FOUND} > 5")
    assert [u for u in browser.requests if not u.startswith("file:")] == []

    shutil.copytree(site, tmp_path / "without")
    (tmp_path / "without" / "assets" / "iframe-worker.js").write_text("")
    browser.open(f"{(tmp_path / 'without' / 'index.html').as_uri()}?q=gripper")
    assert not browser.run(f"new Promise(r => setTimeout(() => r({FOUND}), 2000))"), "a worker starts from a file: drop the shim"


SHOWN = {
    "#continuous-integration": ("CI", "GitHub Actions"),
    "#license": ("licences", "licence of models", "GPL"),
    "#stable-version": ("upgrade", "stability"),
    "#isaac": ("Isaac", "Gazebo"),
    "#ursim": ("URSim",),
    "#collision-checking": ("collision", "minimum clearance"),
    "#pose-uncertainty": ("tolerance", "pose uncertainty"),
    "#a-step-fails": ("recovery", "retry", "retries", "step fails"),
    "#speed-limits": ("speed limits", "acceleration limits"),
    "#shorter-programs": ("cycle time",),
    "#peg-in-hole": ("peg in hole",),
    "#learn-from-video": ("video",),
    "#training-data": ("dataset", "imitation"),
    "#calibrate-a-camera": ("hand-eye",),
    "#plc": ("PLC",),
    "#palletising": ("bin picking",),
    "#run-it-on-a-real-robot": ("teach pendant", "firmware"),
    "#own-gripper": ("grippers", "TCP offset"),
    "#singularity": ("singularities", "joint limits"),
    "#safety": ("emergency stop", "ISO"),
    "#requirements": ("telemetry", "GPU", "Docker"),
    "#reasons-why": ("why",),
    "#time-limit": ("time limit", "timeout"),
    "#two-arms": ("two arms", "suction"),
    "glossary.html#roles": ("SOMA",),
}
"""The section that the search shows first, for each of some words."""
TYPED = """(query => {
    const box = document.querySelector("[data-md-component=search-query]");
    box.value = query;
    box.dispatchEvent(new Event("keyup", {bubbles: true}));
})"""
FIRST = "[...document.querySelectorAll('.md-search-result__item:first-child a')].slice(0, 2).map(e => e.href).join(' ')"


@pytest.mark.heavy
def test_words_that_people_type_are_found(site: Path, browser: Browser) -> None:
    browser.look(1280)
    browser.open(f"{(site / 'index.html').as_uri()}?q=gripper")
    browser.wait(f"{FOUND} > 5")
    for section, queries in SHOWN.items():
        for query in queries:
            browser.run(f"{TYPED}('xyzzy')")
            browser.wait(f"{FOUND} === 0")
            browser.run(f"{TYPED}({query!r})")
            browser.wait(f"{FOUND} > 0")
            assert section in browser.run(FIRST), query


def test_code_is_seen_whole(site: Path, browser: Browser) -> None:
    browser.look(1280)
    for page in PAGES:
        browser.open((site / page).as_uri())
        assert browser.run(TOO_WIDE) == [], page
    browser.look(400)
    assert browser.run(TOO_WIDE) != [], "a telephone is too narrow for it"
