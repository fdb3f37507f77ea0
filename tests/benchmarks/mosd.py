"""Segments of unknown things in real Kinect pictures: overlap and boundary F on mOSD (Alexandrov; OSD: Richtsfeld et al., IROS 2012).

Each label from 20 on is an object, as the data's README counts: disjoint parts of one thing have labels of their own. Masks are matched
to labels by the Hungarian method on F; precision is overlap by pixels of all masks, recall overlap by pixels of all labels,
summed over objects; of boundaries the same, within 0.75 % of the picture's diagonal (Xie et al., UOIS-Net, T-RO 2021).
Labels are read here and nowhere else: perception is given depth and colour.

    python tests/benchmarks/mosd.py FOLDER --half open
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np
from figure import add_figure, value, write
from numpy.typing import NDArray
from scipy import ndimage
from scipy.optimize import linear_sum_assignment

from cramlite import Engine
from cramlite.experiment.figure import Number
from cramlite.perception.active_perception import ask
from cramlite.perception.query import ObjectQuery
from cramlite_plugins.perception.recordings.cloud_files import pcd_rows
from cramlite_plugins.perception.recordings.view_files import read_view

Masks = list[NDArray[np.bool_]]
FIRST = 20
"""Smallest label of an object."""
NEAR = 0.0075
"""Share of the diagonal within which boundaries agree."""
COUNTS = ("overlap", "masks", "labels", "border of masks", "masks' border", "border of labels", "labels' border")


def labels(path: Path) -> Masks:
    """Masks of the objects in a cloud's field ``label``."""
    rows, size = pcd_rows(path.read_bytes(), path)
    assert size is not None
    image = rows["label"][:, 0].reshape(size)
    return [image == k for k in np.unique(image) if k >= FIRST]


def border(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels of a mask beside others."""
    return np.asarray(mask & ~ndimage.binary_erosion(mask))


def counts(found: Masks, true: Masks) -> NDArray[np.float64]:
    """Pixels by ``COUNTS``: what agrees, and of how many."""
    overlap = np.array([[np.count_nonzero(f & t) for t in true] for f in found], float).reshape(len(found), len(true))
    sizes, wanted = np.array([f.sum() for f in found], float), np.array([t.sum() for t in true], float)
    own, other = linear_sum_assignment(-2 * overlap / (sizes[:, None] + wanted[None])) if found else ([], [])
    reach = int(np.ceil(NEAR * np.hypot(*true[0].shape)))
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    around = x * x + y * y <= reach * reach
    lines, truths = [border(f) for f in found], [border(t) for t in true]
    right = sum(np.count_nonzero(lines[a] & ndimage.binary_dilation(truths[b], around)) for a, b in zip(own, other, strict=True))
    seen = sum(np.count_nonzero(truths[b] & ndimage.binary_dilation(lines[a], around)) for a, b in zip(own, other, strict=True))
    whole = sum(map(np.count_nonzero, lines)), sum(map(np.count_nonzero, truths))
    return np.array([overlap[own, other].sum(), sizes.sum(), wanted.sum(), right, whole[0], seen, whole[1]], float)


def rates(c: NDArray[np.float64]) -> dict[str, float]:
    """Precision, recall and F of overlap and boundary [%]."""
    found = {}
    for name, precision, recall in (("overlap", c[0] / max(c[1], 1), c[0] / c[2]), ("boundary", c[3] / max(c[4], 1), c[5] / c[6])):
        both = 2 * precision * recall / max(precision + recall, 1e-9)
        found |= {f"{name} precision": 100 * precision, f"{name} recall": 100 * recall, f"{name} F": 100 * both}
    return found


def files(folder: Path, half: str) -> list[Path]:
    """Scenes by number; those of even place were open while the method was made."""
    ordered = sorted(folder.glob("*.pcd"), key=lambda p: int("".join(filter(str.isdigit, p.stem)) or 0))
    return {"open": ordered[::2], "held": ordered[1::2], "all": ordered}[half]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="with mOSD's PCD files")
    parser.add_argument("--half", choices=("open", "held", "all"), default="all")
    add_figure(parser)
    options = parser.parse_args()
    knowledge, each, seconds = Engine().knowledge, dict[str, Any](), []
    for path in files(options.folder, options.half):
        view, begin = read_view(path), time.process_time()
        said = ask(ObjectQuery(wanted=("segments",)), view, (), knowledge).scene.get("segments")
        seconds.append(time.process_time() - begin)
        masks, true = [s.mask for s in said.value] if said else [], labels(path)
        each[path.stem] = rates(counts(masks, true))
        line = ", ".join(f"{k} {v:.1f}" for k, v in each[path.stem].items())
        print(f"{path.stem}: {len(masks)} of {len(true)}, {seconds[-1]:.2f} s, {line}")
    numbers: list[Number] = [value(k, float(np.mean([e[k] for e in each.values()])), "%") for k in next(iter(each.values()))]
    numbers += [value("overlap F, worst scene", min(e["overlap F"] for e in each.values()), "%")]
    numbers += [value("CPU a scene, median", 1000 * float(np.median(seconds)), "ms"), value("scenes", len(each))]
    for n in numbers:
        print(f"{n.what}: {n.value} {n.unit}")
    write(options, numbers, seeds=f"{len(each)} scenes: {', '.join(each)}")


if __name__ == "__main__":
    main()
