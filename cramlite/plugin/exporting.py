"""Export of runs: an exporter's file or folder is written completely, or not at all."""

from __future__ import annotations

import shutil
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import UserError

if TYPE_CHECKING:
    from ..model.run.run_record import RunRecord
    from .protocols import Exporter


def require_installed(exporter: Exporter) -> None:
    """Check that the packages that an export format needs are installed.

    Raises:
        UserError: one is not.
    """
    for package, install in exporter.needs.items():
        if find_spec(package) is None:
            raise UserError(f"The format '{exporter.name}' needs the package {package}, which is not installed: pip install '{install}'.")


def require_absent(target: Path) -> None:
    """Check that nothing exists yet at the path of an export.

    Raises:
        UserError: something is.
    """
    if target.exists():
        raise UserError(f"'{target}' exists already and nothing was written; delete it, or choose another place.")


def write_new(exporter: Exporter, record: RunRecord, target: Path) -> None:
    """Write a run to a path where nothing exists; a half-written file or folder is removed.

    Raises:
        UserError: something is there, or it cannot be written.
    """
    require_absent(target)
    try:
        exporter.write(record, target)
    except OSError as error:
        _take_away(target)
        raise UserError(f"'{target}' cannot be written: {error.strerror or error}; choose another place.") from error
    except BaseException:  # interrupted, or a defect of the exporter
        _take_away(target)
        raise


def _take_away(target: Path) -> None:
    if target.is_dir():
        shutil.rmtree(target, ignore_errors=True)
    elif target.is_file():
        target.unlink()
