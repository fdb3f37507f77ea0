"""What benchmarks share: ``--figure NAME`` writes ``docs/figures/NAME.yaml``, from which the page of figures is made.

``--seen`` says whether the seeds had been run before (no, partly, yes); left out, that is not recorded. Title, introduction, plot and
published figures are written by hand into the file, and stay when it is written again.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable
from pathlib import Path

from cramlite.experiment.figure import Number, write_figure
from cramlite.experiment.measured import SUFFIX, check_figure_file, figure_now, rate, repeated, value
from cramlite.plugin import UserError

FOLDER = Path(__file__).parents[2] / "docs" / "figures"
__all__ = ["add_figure", "rate", "value", "write"]
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # processes that benchmarks start share compiled modules, as those of users do


def add_figure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--figure", type=_file, metavar="NAME", help="write docs/figures/NAME.yaml")
    parser.add_argument("--seen", choices=("no", "partly", "yes"), help="had these seeds been run before? For the figure")


def write(
    options: argparse.Namespace, numbers: Iterable[Number], seeds: range | str | None = None, cpu_s: float | None = None
) -> None:
    """Write the figure, if one is asked for.

    Args:
        seeds: which were run.
        cpu_s: CPU time of it all [s], where this process and its children did not do the work.
    """
    if options.figure is None:
        return
    said = f"{seeds[0]} to {seeds[-1]}" if isinstance(seeds, range) else seeds
    program = f"python tests/benchmarks/{Path(sys.argv[0]).name}"
    made = figure_now(options.figure.stem, repeated(program, sys.argv[1:]), numbers, seeds=said, seen=options.seen, cpu_s=cpu_s)
    write_figure(options.figure, made)
    print(f"Figure: {options.figure}")


def _file(name: str) -> Path:
    path = FOLDER / f"{name}{SUFFIX}"
    if path.parent != FOLDER or not name.isidentifier():
        raise argparse.ArgumentTypeError(f"'{name}' is no name of a figure; use letters, digits and '_', such as kitchens")
    try:
        check_figure_file(path)
    except UserError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return path
