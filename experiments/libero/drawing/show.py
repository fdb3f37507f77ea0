"""Show the scenes of random problems in one picture, as the benchmark's camera sees them, with their goals in words.

    problems/bin/python experiments/libero/drawing/show.py 0:12 --out sheet.png

It runs in the benchmark's environment with the suite, ``bin/python`` of a folder of problems.
"""

from __future__ import annotations

import argparse
import base64
import io
import sys
import textwrap
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(1, str(Path(__file__).resolve().parents[2]))

from PIL import Image, ImageDraw
from seed_ranges import seeds_of
from simulator import PIXELS, Simulator

COLUMNS, LINE, WIDTH = 4, 12, 40
"""Pictures in a row, height of a line of text [pixel], and largest number of characters in a line."""


def picture(simulator: Simulator, seed: int) -> tuple[Any, str]:
    """Return the camera picture of a problem's start, and the problem's name."""
    name = str(simulator.reset("drawn", seed, 0)["task"])
    return Image.open(io.BytesIO(base64.b64decode(simulator.cameras()["agentview"]["png"]))), name


def sheet(simulator: Simulator, seeds: range) -> Any:
    """Return one image that shows the start of each randomly drawn problem, with its name below."""
    high = PIXELS + 6 * LINE
    found = Image.new("RGB", (COLUMNS * PIXELS, -(-len(seeds) // COLUMNS) * high), "white")
    draw = ImageDraw.Draw(found)
    for k, seed in enumerate(seeds):
        x, y = k % COLUMNS * PIXELS, k // COLUMNS * high
        seen, name = picture(simulator, seed)
        found.paste(seen, (x, y))
        draw.text((x + 2, y + PIXELS), textwrap.fill(f"{seed}: {name}", WIDTH), fill="black")
    return found


def main() -> None:
    """Write the sheet of pictures for the seeds that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("seeds", help="such as 0:12, which ends with 11; those for development")
    parser.add_argument("--out", type=Path, default=Path("sheet.png"))
    order = parser.parse_args()
    try:
        seeds = seeds_of(order.seeds)
    except ValueError as error:
        sys.exit(str(error))
    sheet(Simulator(), seeds).save(order.out)


if __name__ == "__main__":
    main()
