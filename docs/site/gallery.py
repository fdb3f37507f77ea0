"""Gallery of the shipped scenarios: each is resolved, its run is drawn as a small animation, and a sentence states the result.

    python docs/site/gallery.py                    # all of them: some 30 minutes on two cores
    python docs/site/gallery.py kitchen/swap ...   # only these

Writes docs/assets/gallery/*.webp, what was found as docs/assets/gallery/found.json, and docs/gallery.md from that. Programs are
proven nominally (--twins 0), at seed 0.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cramlite import Engine, read_scenario
from cramlite.cli.program_input import recorded

DOCS = Path(__file__).resolve().parents[1]
SCENARIOS = DOCS.parent / "scenarios"
PICTURES = DOCS / "assets" / "gallery"
FOUND, PAGE = PICTURES / "found.json", DOCS / "gallery.md"
SIZE = (320, 240)
RATE, FASTER, LONGEST = 4.0, 3.0, 90
"""Frames per second of the run, speed-up of the animation, and largest number of frames of an animation."""
TITLES = {
    "": "Whole jobs", "kitchen": "Kitchen", "compound": "Several tasks in one", "tasks": "One task each",
}  # fmt: skip


def names() -> list[str]:
    """Return the names of all shipped scenarios: their paths below ``scenarios``."""
    found = [p for p in SCENARIOS.glob("**/*.yaml") if "demonstration" not in p.parts]
    return sorted(p.relative_to(SCENARIOS).with_suffix("").as_posix() for p in found)


def run(name: str) -> dict[str, Any]:
    """Resolve a scenario, draw its run, and return its entry of the gallery."""
    file = SCENARIOS / f"{name}.yaml"
    about = {"title": read_scenario(file).spec.title, "about": remark(file)}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        words = ["resolve", str(file), "--twins", "0", "--no-report", "--json", "--out", str(out)]
        done = subprocess.run([sys.executable, "-m", "cramlite", *words], capture_output=True, text=True, check=False)
        if not done.stdout.startswith("{"):
            return {**about, "solved": False, "said": done.stderr.strip().removeprefix("cramlite: "), "picture": False}
        result = json.loads(done.stdout)
        place = next((p for p in (out / "execution", out) if (p / "rollout.npz").is_file()), None)
        if place is not None:
            animate(place, PICTURES / f"{name.replace('/', '-')}.webp")
    said = result["plan"] if result["solved"] else nearest(result)
    return {**about, "solved": result["solved"], "said": said, "picture": place is not None}


def remark(file: Path) -> str:
    """Return the comment that a scenario file begins with."""
    lines = takewhile(lambda line: line.startswith("#"), file.read_text("utf-8").splitlines())
    return " ".join(line.lstrip("# ") for line in lines).removeprefix("Must fail. ")


def nearest(result: Mapping[str, Any]) -> str:
    """Return why nothing was proven: the nearest miss and its designator, if there is one, else the search's reason."""
    miss = result["nearest"]
    return f"{miss['designator']}: {miss['reason']}" if miss else str(result["reason"])


def animate(run: Path, out: Path) -> None:
    """Draw a recorded run as an animated picture."""
    knowledge = Engine().knowledge
    rollout = recorded(run, None, knowledge)
    wanted = np.arange(rollout.times[0], rollout.times[-1], max(1 / RATE, rollout.times[-1] / LONGEST))
    samples = [int(k) for k in np.searchsorted(rollout.times, wanted)]
    first, *others = [Image.fromarray(knowledge.simulator.picture(rollout, k, knowledge.robots, SIZE)) for k in samples]
    pause = 1000 * float(wanted[1] - wanted[0]) / FASTER if others else 1000.0
    first.save(out, save_all=True, append_images=others, duration=round(pause), loop=0, quality=35, method=6)


def page(found: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the gallery page as Markdown."""
    parts = [
        "# Gallery", "",
        "Every shipped scenario, as `cramlite resolve NAME --twins 0` leaves it at seed 0, three times as fast as it ran. A",
        "scenario that must fail stands beside one that succeeds, with one difference. Made by `python docs/site/gallery.py`.",
    ]  # fmt: skip
    for folder, title in TITLES.items():
        inside = {name: entry for name, entry in found.items() if name.rpartition("/")[0] == folder}
        parts += ["", f"## {title}", "", "| scenario | run | what comes of it |", "|---|---|---|", *rows(inside)]
    return "\n".join(parts) + "\n"


def rows(found: Mapping[str, Mapping[str, Any]]) -> Iterable[str]:
    for name, entry in found.items():
        source = f"assets/gallery/{name.replace('/', '-')}.webp"
        picture = f'<img src="{source}" alt="{entry["title"]}" width="{SIZE[0]}" loading="lazy">' if entry["picture"] else ""
        said = " ".join(str(entry["said"]).split()).replace("|", "\\|").replace("<", "&lt;")
        outcome = f"Solved: {said}" if entry["solved"] else f"Refused. {said}"
        yield f"| `{name}` | {picture} | **{entry['title']}.** {entry['about']}<br>{outcome} |"


def main(asked: list[str]) -> None:
    """Make the gallery's entries of the named scenarios, of all if none is named, and write the page."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    known = json.loads(FOUND.read_text()) if FOUND.is_file() else {}
    wanted = asked or names()
    with ThreadPoolExecutor(2) as pool:
        for name, entry in zip(wanted, pool.map(run, wanted), strict=True):
            print(f"{name}: {'solved' if entry['solved'] else 'refused'}", flush=True)
            known[name] = entry
    found = {name: known[name] for name in names() if name in known}
    FOUND.write_text(json.dumps(found, indent=1) + "\n")
    PAGE.write_text(page(found))


if __name__ == "__main__":
    main(sys.argv[1:])
