"""6D poses of products on hangers from one noisy depth image: cramlite's method, the paper's recipe, one ICP, Open3D and
small_gicp.

The views are those of pose_views.py; every method is given the same ones, the same masks and the same prior (upright).
Right: under 5 degrees and 5 mm, of symmetric poses the nearest. CPU time is that of one core, model preparation left out
(it is done once a product).

    OMP_NUM_THREADS=1 python tests/benchmarks/perception_pose.py --set test --easy 120 --hard 120
"""

from __future__ import annotations

import os

from figure import add_figure, rate, value, write

from cramlite.experiment.figure import Number

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2] / "experiments" / "pose_recipes"))

import paper_registration
import pose_views

from cramlite.base.rate import wilson_interval
from cramlite.plugin import UserError
from cramlite_plugins.perception.pose import libraries as pose_libraries
from cramlite_plugins.perception.pose.estimate import PoseHypothesis, estimate
from cramlite_plugins.perception.pose.model import PoseModel
from cramlite_plugins.perception.pose.prior import UPRIGHT

METHODS: dict[str, Callable[..., list[PoseHypothesis]]] = {
    "ours": estimate,
    "small_gicp, 24 point-to-plane": pose_libraries.small_gicp_pose,
    "Open3D, 24 point-to-plane": pose_libraries.open3d_pose,
    "paper: PCA, 12 point-to-point": paper_registration.paper,
    "one point-to-plane ICP, upright": paper_registration.one_plane_icp,
    "one point-to-point ICP": paper_registration.one_icp,
}
RIGHT = (0.005, math.radians(5))
CONFIDENT = 0.6


@dataclass(frozen=True)
class Outcome:
    """Errors of the best pose: centre and hole [m], rotation [rad]; its score; CPU time [s]."""

    metres: float
    angle: float
    hole: float
    score: float
    seconds: float

    @property
    def right(self) -> bool:
        return self.metres < RIGHT[0] and self.angle < RIGHT[1]


def run(method: Callable[..., list[PoseHypothesis]], sample: pose_views.Sample) -> Outcome:
    """Result of one method on one view."""
    model = pose_views.model_of(sample.product)
    begin = time.process_time()
    found = method(sample.view, sample.mask, model, UPRIGHT)
    seconds = time.process_time() - begin
    if not found:
        return Outcome(math.inf, math.pi, math.inf, 0.0, seconds)
    metres, angle = model.difference(found[0].pose, sample.truth)
    return Outcome(metres, angle, _hole(model, found[0], sample), found[0].score, seconds)


def _hole(model: PoseModel, found: PoseHypothesis, sample: pose_views.Sample) -> float:
    """How far the hole is from where it is [m], of symmetric poses the nearest."""
    hole = next(f.pose for f in model.features if f.type == "vrps:Hole")
    truth = (sample.truth * hole).position
    return min(math.dist((found.pose * s * hole).position, truth) for s in model.symmetries)


def prepare(samples: list[pose_views.Sample]) -> None:
    """What is made once a product: grids, twins and trees."""
    for sample in samples:
        model = pose_views.model_of(sample.product)
        _ = model.grid, model.opposite_points, model.tree


def row(name: str, outcomes: list[Outcome]) -> str:
    """One line of the table."""
    right = sum(o.right for o in outcomes)
    low, high = wilson_interval(right, len(outcomes))
    wrong = sum(not o.right and o.score > CONFIDENT for o in outcomes) / len(outcomes)
    angle, metres, hole = (np.array([getattr(o, k) for o in outcomes]) for k in ("angle", "metres", "hole"))
    cpu = np.array([o.seconds for o in outcomes]) * 1000
    return (
        f"| {name} | {right / len(outcomes):.3f} ({low:.3f} to {high:.3f}) | {np.degrees(np.median(angle)):.2f} deg / "
        f"{1000 * np.median(metres):.2f} mm | {1000 * np.median(hole):.2f} / "
        f"{1000 * np.quantile(hole, 0.95, method='lower'):.1f} mm | {wrong:.3f} | {cpu.mean():.0f} / "
        f"{np.quantile(cpu, 0.95):.0f} ms |"
    )


def table(title: str, samples: list[pose_views.Sample], names: list[str]) -> list[Number]:
    """Run the methods and print the table; return the shares that are right."""
    numbers = []
    prepare(samples)
    seen = [s.visibility for s in samples]
    print(
        f"\n{title}: {len(samples)} views, seeds {samples[0].seed} to {samples[-1].seed}, visibility {np.mean(seen):.2f} on average"
    )
    print(
        "| method | under 5 deg and 5 mm (95 %) | median | hole, median / p95 | wrong with score > .6 | CPU, mean / p95 |"
    )
    print("|---|---|---|---|---|---|")
    for name in names:
        try:
            outcomes = [run(METHODS[name], s) for s in samples]
            print(row(name, outcomes), flush=True)
            numbers.append(rate(name, sum(o.right for o in outcomes), len(outcomes), title))
            numbers.append(value(name, 1000 * float(np.mean([o.seconds for o in outcomes])), "ms", f"{title}, CPU, mean"))
        except UserError as error:
            print(f"| {name} | not run: {error} | | | | |", flush=True)
    return numbers


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--set", choices=("development", "test"), default="development")
    parser.add_argument("--easy", type=int, default=24)
    parser.add_argument("--hard", type=int, default=24)
    parser.add_argument("--methods", nargs="*", default=list(METHODS), metavar="NAME", help=", ".join(METHODS))
    add_figure(parser)
    arguments = parser.parse_args()
    first = pose_views.TEST if arguments.set == "test" else pose_views.DEVELOPMENT
    numbers = list[Number]()
    for title, count, hard in (("EASY", arguments.easy, False), ("HARD", arguments.hard, True)):
        if count:
            numbers += table(title, [pose_views.sample(first + k, hard) for k in range(count)], arguments.methods)
    write(arguments, numbers, f"from {first}: {arguments.easy} EASY, {arguments.hard} HARD")


if __name__ == "__main__":
    main()
