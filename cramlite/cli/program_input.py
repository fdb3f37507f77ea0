"""Inputs of commands about a program: its text, its world, and the recorded run of its run directory."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..base.errors import UserError
from ..model.run.rollout import Rollout, load_rollout
from ..model.world.world import World
from ..plugin.catalogue import Knowledge
from ..scenario.worlds import read_world

PACKED = b"\x1f\x8b"
"""First bytes of a gzip file."""


def robots_world(world: str, program: Path, knowledge: Knowledge, seed: int) -> World:
    """Read a world that has at least one robot.

    Raises:
        UserError: it cannot be read, or nobody is there to act.
    """
    place = read_world(world, knowledge, seed)
    if not place.robots:
        raise UserError(f"The world '{world}' has no robot, so nothing can run '{program}'.")
    return place


@contextmanager
def naming(program: Path) -> Iterator[None]:
    """Put the program's path before errors about its text, since the simulator does not know the path."""
    try:
        yield
    except UserError as error:
        raise UserError(f"{program}: {error}") from error


def read_text(program: Path) -> str:
    """Read the text of a program.

    Robot programs of Windows editors are taken, too: comments in its Western code page, where they are not UTF-8.

    Raises:
        UserError: it cannot be read, or is no text.
    """
    try:
        found = program.read_bytes()
        return found.decode()
    except OSError as error:
        raise UserError(f"The program '{program}' cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        if found.startswith(PACKED):
            why = "PolyScope's .urp is; take the .script that PolyScope saves beside it"
            raise UserError(f"'{program}' is no text: it is compressed, as {why}.") from error
        if b"\0" in found or program.suffix == ".json":
            raise UserError(f"'{program}' is no text: byte {error.start} is not UTF-8.") from error
        return found.decode("cp1252", "replace")


def recorded(run: Path, world: str | None, knowledge: Knowledge, seed: int = 0) -> Rollout:
    """Read the run that a folder holds.

    Raises:
        UserError: there is none, or nobody says in which world it was.
    """
    file, own = run / "rollout.npz", run / "world.json"
    if not file.is_file():
        raise UserError(
            f"'{run}' holds no recorded run (no rollout.npz): give a folder that 'cramlite resolve --out' or 'cramlite "
            "execute --out' wrote. A run in which nothing was proven, or of a backend whose text cannot be run here, has "
            "none; its report.html shows what there is."
        )
    if world is None and not own.is_file():
        raise UserError(
            f"'{run}' does not say in which world it was (no world.json): give it with --world, as 'cramlite execute' was."
        )
    return load_rollout(file, read_world(world or str(own), knowledge, seed))


@contextmanager
def in_its_world() -> Iterator[None]:
    """Name the option --world where a recorded run and the world that was given for it do not fit."""
    try:
        yield
    except (KeyError, IndexError, ValueError) as error:
        raise UserError(f"The run was not in this world ({error}); give the one it was in with --world.") from error


def program_of(run: Path, *, typed: bool = False) -> list[str]:
    """Return the lines of the program text in a run directory; none where it holds no text that can be read.

    Args:
        typed: whether the typed program (JSON) stands for a missing text.
    """
    found = sorted(p for p in run.glob("program.*") if p.suffix != ".json") or ([run / "program.json"] if typed else [])
    try:
        return found[0].read_text("utf-8").splitlines() if found else []
    except (OSError, UnicodeDecodeError):
        return []
