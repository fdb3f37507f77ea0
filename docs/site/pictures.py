"""Pictures for README and docs. Those of pages are taken in a headless Chromium (which must be installed).

    python docs/site/pictures.py RECORDING SCENARIO

Writes docs/assets/report.png (the report of fetch_from_hanger), docs/assets/reading.png (what ``cramlite interpret --html`` says of
a recording, e.g. one of a person in virtual reality) and docs/assets/foreign_scene.webp (the run of a scenario whose world is
somebody else's file: the one shown is robosuite's PickPlaceCan with ``goal: [Can_main in bin2]``).
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(DOCS.parent / "tests"))

from gallery import animate  # noqa: E402
from helpers.headless import Browser, chromium  # noqa: E402

WIDTH, COLOURS = 1100, 128
"""Width of the browser window [pixel], and number of colours of a saved picture."""


def cramlite(*words: object) -> None:
    """Run this checkout's ``cramlite`` with the given arguments, without its output."""
    subprocess.run([sys.executable, "-m", "cramlite", *map(str, words)], check=True, stdout=subprocess.DEVNULL)


def take(page: Path, out: Path, height: int) -> None:
    """Save a screenshot of the upper part of an HTML page, in few colours."""
    browser = chromium()
    assert browser is not None, "install Chromium first"
    with Browser(browser) as found:
        found.look(WIDTH, height)
        found.open(page.as_uri())
        found.screenshot(out)
    Image.open(out).convert("RGB").quantize(COLOURS).save(out, optimize=True)


def main(recording: str, foreign: str) -> None:
    """Make the three pictures of ``docs/assets``: a report, a reading and a run in a foreign scene."""
    with tempfile.TemporaryDirectory() as folder:
        run, reading = Path(folder) / "run", Path(folder) / "reading.html"
        cramlite("resolve", "fetch_from_hanger", "--out", run)
        take(run / "report.html", DOCS / "assets" / "report.png", 1850)
        cramlite("interpret", recording, "--html", reading)
        take(reading, DOCS / "assets" / "reading.png", 900)
        there = Path(folder) / "there"
        cramlite("resolve", foreign, "--twins", "0", "--no-report", "--out", there)
        animate(next(p for p in (there / "execution", there) if (p / "rollout.npz").is_file()), DOCS / "assets" / "foreign_scene.webp")


if __name__ == "__main__":
    main(*sys.argv[1:])
