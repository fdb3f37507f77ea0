"""Paths of the shipped ontologies, task rules, scenarios and experiments, in the wheel or in a checkout."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from .errors import UserError, nearest


def data_folder(kind: str) -> Path:
    """Return the folder of the shipped "ontologies", "task_rules", "scenarios" or "experiments"."""
    package = Path(__file__).resolve().parents[1]
    wheel = package / "data" / kind
    return wheel if wheel.is_dir() else package.parent / kind


def find_scenario(name: str) -> Path:
    """Find a scenario file by path, or by the name of a shipped one, with or without its folder ("tasks/grasping").

    Raises:
        UserError: there is no such file; lists those of its folder and the shipped ones, the nearest first.
    """
    path = Path(name)
    try:
        if path.is_file():
            return path
    except OSError as error:  # longer than names of files may be
        raise UserError(f"'{name[:60]}...' cannot be the name of a file: {error.strerror}.") from None
    try:
        return shipped_scenario(name, _yaml_files_near(path))
    except UserError:
        if path.is_dir():
            raise UserError(f"'{name}' is a folder; give a scenario file in it.") from None
        raise


def _yaml_files_near(path: Path) -> list[str]:
    """Return the paths of the YAML files that lie in the same folder as a file."""
    return [str(p) for pattern in ("*.yaml", "*.yml") for p in path.parent.glob(pattern)]


def shipped_scenarios() -> dict[str, Path]:
    """Return the file of each shipped scenario by its name without a folder."""
    return {p.stem: p for p in sorted(data_folder("scenarios").glob("**/*.yaml"))}


def shipped_scenario(name: str, others: Iterable[str] = ()) -> Path:
    """Find a shipped scenario by its name, with or without its folder.

    Args:
        others: further names that may have been meant.

    Raises:
        UserError: none is called so; lists them, the nearest first.
    """
    folder, shipped = data_folder("scenarios"), shipped_scenarios()
    full = {p.relative_to(folder).with_suffix("").as_posix(): p for p in shipped.values()}
    if name in full or name in shipped:
        return full.get(name) or shipped[name]
    raise UserError(f"There is no scenario file '{name}', and none of that name is shipped; {nearest(name, {*others, *shipped})}.")
