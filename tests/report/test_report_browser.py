"""The report as a person meets it: a real headless Chromium, both widths, both colour schemes, mouse and keyboard.

Where there is no Chromium, the same pages are checked without one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import Proven
from helpers.headless import Browser, chromium
from helpers.page_checks import Page, faults

from cramlite import Engine
from cramlite.base.run_directory import RunDirectory
from cramlite.report import write_report

SHIPPED = ["fetch_from_hanger", "hang_onto_hanger", pytest.param("fetch_from_hanger_camera", marks=pytest.mark.heavy)]

TOO_WIDE = """[...document.querySelectorAll("main *")]
  .filter(e => e.getBoundingClientRect().right > innerWidth + 1 && !e.closest(".scroll, .listing, .strip, details:not([open])"))
  .map(e => e.outerHTML.slice(0, 80))"""
NAMELESS = """[...document.querySelectorAll("button, a, input, canvas")]
  .filter(e => !(e.textContent.trim() || e.getAttribute("aria-label") || e.title)).map(e => e.outerHTML.slice(0, 80))"""
COLOURS = """(() => {
  const c = document.querySelector(".screen"), found = new Set();
  const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
  for (let i = 0; i < d.length; i += 44) found.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]);
  return found.size;
})()"""
DECIDED = '[...document.querySelectorAll(".blk a.from")].find(a => document.getElementById(a.hash.slice(1)).matches(".decision"))'
PICTURE = 'document.querySelector(".screen").toDataURL()'
TICK = '+document.querySelector("#run input").value'


@pytest.fixture(scope="module", params=SHIPPED)
def report(request: pytest.FixtureRequest, proven: Proven, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a shipped scenario."""
    engine, folder = Engine(), tmp_path_factory.mktemp(request.param)
    write_report(RunDirectory(folder, {}), proven(request.param), engine)
    assert not engine.registry.faults
    return folder / "report.html"


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    found = chromium()
    if found is None:
        pytest.skip("there is no Chromium; the pages are checked without one")
    with Browser(found) as running:
        yield running


@pytest.fixture
def page(browser: Browser, report: Path) -> Browser:
    """The page, opened anew."""
    browser.look(1200)
    browser.errors.clear()
    browser.requests.clear()
    browser.open(report.as_uri())
    return browser


@pytest.mark.heavy
def test_a_page_is_whole_without_a_browser_too(report: Path) -> None:
    text = report.read_text("utf-8")
    assert faults(text) == []
    parsed = Page(text)
    assert parsed.tags["canvas"] == 1 and parsed.tags["svg"] >= 10
    assert 4 <= parsed.images <= 30
    camera = "fetch_from_hanger_camera" in str(report)
    assert ("What it saw</h2>" in text) == camera


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        ('<p id="a"></p><p id="a"></p>', "occurs 2 times"),
        ('<a href="#nowhere">x</a>', "which is not there"),
        ('<img src="https://example.org/x.png">', "not within the page"),
        ("<script src=x.js></script>", "not within the page"),
        ("<style>p { background: url(x.png) }</style>", "a style fetches"),
        ("<p><b>x</p></b>", "not closed in order"),
        ("<p>" + "x" * 5_000_001 + "</p>", "bytes"),
    ],
)
def test_a_broken_page_is_noticed(broken: str, said: str) -> None:
    assert any(said in fault for fault in faults(broken))


@pytest.mark.parametrize("width", [1200, 390])
@pytest.mark.parametrize("dark", [False, True])
def test_it_fits_and_fetches_nothing(page: Browser, report: Path, width: int, dark: bool) -> None:
    page.look(width, dark=dark)
    page.call("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=0, uploadThroughput=0)
    page.open(report.as_uri())
    assert page.run("document.documentElement.scrollWidth") <= width
    assert page.run(TOO_WIDE) == []
    background = [int(v) for v in re.findall(r"\d+", page.run("getComputedStyle(document.body).backgroundColor"))]
    assert (sum(background) < 200) == dark
    assert page.errors == []
    assert set(page.requests) == {report.as_uri()}


def drawn(page: Browser) -> str:
    """What the canvas shows once it is drawn."""
    page.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return str(page.run(PICTURE))


def test_the_run_is_drawn_and_scrubbed_by_keyboard(page: Browser) -> None:
    page.run("document.querySelector('#run input').focus()")
    start = drawn(page)
    assert page.run(COLOURS) > 60
    page.press("ArrowRight", 100)
    assert page.run(TICK) == 100
    assert page.run("document.querySelector('#run output').textContent") == "5.00 s"
    moved = drawn(page)
    assert moved != start
    assert page.run("document.querySelector('#run .cursor').getBoundingClientRect().x") > 0
    page.press("Home")
    assert drawn(page) == start
    page.press(" ")
    page.wait(f"{TICK} > 0")
    page.press(" ")
    assert page.run("document.querySelector('.play').getAttribute('aria-pressed')") == "false"


def test_the_scene_turns_by_keyboard(page: Browser) -> None:
    page.run("document.querySelector('.screen').focus()")
    before = drawn(page)
    page.press("ArrowLeft")
    assert drawn(page) != before
    page.press("ArrowRight")
    assert page.run(TICK) == 0
    assert drawn(page) == before


def test_why_not_on_hover_and_by_keyboard(page: Browser) -> None:
    said = "document.getElementById('why').textContent"
    page.hover(".cell.no")
    assert page.run(said) == page.run("document.querySelector('.cell.no').dataset.why")
    assert page.run("document.querySelectorAll('.cell[tabindex=\"0\"]').length") == 1
    page.run("document.querySelector('.cell[tabindex=\"0\"]').focus()")
    first = page.run(said)
    assert "conditions hold" in first
    page.press("ArrowDown")
    assert page.run(said) == page.run("document.activeElement.dataset.why") != first
    rows = (
        "document.querySelectorAll('.matrix tr').length - document.querySelectorAll('.matrix tbody[hidden] tr').length"
    )
    folded = page.run(rows)
    page.run("document.getElementById('fold').focus()")
    page.press("Enter")
    assert page.run(rows) > folded


def test_lines_lead_to_decisions_and_back(page: Browser) -> None:
    page.run(f"({DECIDED}).focus()")
    line = page.run("document.activeElement.closest('.ln').id")
    page.press("Enter")
    page.wait("document.querySelector('.decision:target') !== null")
    page.run("document.querySelector('.decision:target .code a').focus()")
    page.press("Enter")
    page.wait("document.querySelector('.ln:target') !== null")
    first, last = page.run("document.querySelector('.ln:target').id"), int(line[1:])
    assert 0 <= last - int(first[1:]) < 12


def test_everything_is_reached_by_the_tab_key(page: Browser) -> None:
    """Whatever can be clicked can be focused, has a name, and shows where the focus is."""
    assert page.run(NAMELESS) == []
    page.press("Tab", 4)
    assert page.run("document.activeElement.closest('nav') !== null")
    assert page.run("getComputedStyle(document.activeElement).outlineStyle") != "none"


def test_a_failing_script_would_be_noticed(page: Browser, tmp_path: Path) -> None:
    broken = tmp_path / "broken.html"
    broken.write_text("<script>nothing.there()</script>")
    page.open(broken.as_uri())
    assert any("nothing is not defined" in e for e in page.errors)
