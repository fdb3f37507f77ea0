"""Writer of tests for a user's robot programs: a draft of the world, one test for each program, and a CI workflow."""

from __future__ import annotations

import ast
import contextlib
import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from ..base.errors import UserError
from ..base.run_directory import require_vacant
from ..base.value import Value
from ..model.program.program_json import is_program_text

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge

TEMPLATES = Path(__file__).parent / "skeletons" / "tests"
LISTED = 5
"""Largest number of unsupported program lines that a generated test lists."""
MODELS = r"\bUR ?(\d{1,2})(e?)\b"
"""Names of robots of Universal Robots in programs and their comments."""


class ProgramFound(Value):
    """Robot program that was found in a folder.

    Args:
        lacks: lines that cannot run on the controller model, as (line, reason).
    """

    path: Path
    lacks: tuple[tuple[int, str], ...] = ()


def write_suite(folder: Path, knowledge: Knowledge, out: Path | None = None) -> tuple[Path, ...]:
    """Write tests for the robot programs of a folder.

    Args:
        folder: with URScript (``.script``), typed programs (``.json``) and Python clients of a UR controller, at any depth.
        out: the folder of the tests; ``robot_tests`` in the folder by default.

    Returns:
        the files, the folder of the tests first.

    Raises:
        UserError: there is no program, or the tests' folder is not empty; nothing was written.
    """
    if not folder.is_dir():
        raise UserError(f"'{folder}' is no folder: give the one that holds your robot programs.")
    tests = out or folder / "robot_tests"
    require_vacant(tests, "written")
    found = list(programs(folder, knowledge))
    if not found:
        raise UserError(
            f"'{folder}' holds no robot program: neither URScript (*.script), nor a typed program (*.json), nor Python that "
            "imports rtde_control or speaks to a controller's ports."
        )
    workflow = folder / ".github" / "workflows" / "robot-programs.yml"
    words = {"robot": _robot(found, knowledge), "tests": Path(os.path.relpath(tests, folder)).as_posix()}
    texts = {
        tests / "cell.yaml": _filled("cell.yaml", words),
        tests / "conftest.py": _filled("conftest.py", words),
        tests / "test_programs.py": _tests(found, tests),
        **({} if workflow.exists() else {workflow: _filled("workflow.yml", words)}),
    }
    for path, text in texts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
    return tests, *texts


def programs(folder: Path, knowledge: Knowledge) -> Iterator[ProgramFound]:
    """Yield the robot programs below a folder, sorted by path."""
    for path in sorted(p for p in folder.rglob("*") if p.suffix in (".script", ".json", ".py") and p.is_file()):
        if any(part.startswith(".") or part in ("node_modules", "site-packages") for part in path.relative_to(folder).parts):
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        if path.suffix == ".script":
            yield ProgramFound(path, tuple(_lacks(text, knowledge)))
        elif (path.suffix == ".json" and is_program_text(text) and '"steps"' in text) or (path.suffix == ".py" and is_client(text)):
            yield ProgramFound(path)


def is_client(text: str) -> bool:
    """Check whether a Python text controls a UR controller: it imports a client of RTDE, or contains one of
    the controller's ports."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return False
    names = {a.name.split(".")[0] for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
    names |= {(n.module or "").split(".")[0] for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
    ports = {n.value for n in ast.walk(tree) if isinstance(n, ast.Constant)} & {29999, 30001, 30002, 30003, 30004}
    return bool(names & {"rtde_control", "rtde_receive", "rtde"} or ("socket" in names and ports))


def _lacks(text: str, knowledge: Knowledge) -> Iterator[tuple[int, str]]:
    """Yield the lines of URScript that cannot run on the controller model, each with the reason.

    A text that is not URScript yields none; its test fails when it is run.
    """
    with contextlib.suppress(UserError):
        yield from ((line, said) for line, said in knowledge.simulator.inspect(text) if said.startswith("cannot run here"))


def _robot(found: Sequence[ProgramFound], knowledge: Knowledge) -> str:
    """Return the robot type that most programs name; a UR5e if none names one."""
    named: list[str] = []
    for one in found:
        text = f"{one.path.name.replace('_', ' ')} {one.path.read_text(encoding='utf-8', errors='replace')}"
        named += [f"ur{number}{series.lower()}" for number, series in re.findall(MODELS, text, re.IGNORECASE)]
    known = [name for name in named if name in knowledge.robots]
    return max(dict.fromkeys(known), key=known.count, default="ur5e")


def _filled(template: str, words: dict[str, str]) -> str:
    return Template((TEMPLATES / f"{template}.txt").read_text(encoding="utf-8")).substitute(words)


def _tests(found: Sequence[ProgramFound], tests: Path) -> str:
    """Return the text of the test file: one test for each program; those that may not run are marked with the
    reason."""
    functions = [_test(one, tests, name) for one, name in zip(found, _names(found), strict=True)]
    skips = "import pytest\n\n\n" if any(one.lacks for one in found) else ""
    about = '"""A test a program: say what it is for, such as .ends("part on tray").leaves("tray").pushes("30 N")."""\n\n'
    return about + skips + "\n\n".join(functions)


def _test(one: ProgramFound, tests: Path, name: str) -> str:
    where = Path(os.path.relpath(one.path, tests)).as_posix()
    body = f"def test_{name}(cramlite_robot):\n    cramlite_robot.run({where!r}).ends()\n"
    if not one.lacks:
        return body
    listed = "".join(f"# line {line}: {said}\n" for line, said in one.lacks[:LISTED])
    more = f"# and {len(one.lacks) - LISTED} more: cramlite check {where}\n" if len(one.lacks) > LISTED else ""
    return f'{listed}{more}@pytest.mark.xfail(reason="it may need what the controller model does not have")\n{body}'


def _names(found: Sequence[ProgramFound]) -> list[str]:
    """Return names of the tests: those of the files, with numbers where two are equal."""
    names: list[str] = []
    for one in found:
        name = re.sub(r"\W+", "_", one.path.stem).strip("_").lower() or "program"
        names.append(name if name not in names else f"{name}_{len(names)}")
    return names


def suite_text(files: Sequence[Path]) -> str:
    """Return text for the user: which test files were written, and what to do next."""
    tests = files[0]
    return "\n".join([
        f"Wrote {', '.join(str(f) for f in files[1:])}.",
        "Next:",
        f"  cramlite show {tests / 'cell.yaml'}       # is this your cell? Correct the file until it is",
        f"  pytest {tests}       # each program comes to its end, or says why not",
        f"Then say in {tests / 'test_programs.py'} what each program is for.",
    ])  # fmt: skip
