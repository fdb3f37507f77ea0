"""Who may import whom: the contracts of pyproject.toml hold, and a contract that does not is seen."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from conftest import ROOT

LINT = "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports(config_filename=sys.argv[1], no_cache=True))"
BROKEN = """
[importlinter]
root_package = cramlite
[importlinter:contract:1]
name = The command line does not use the pipeline
type = forbidden
source_modules = cramlite.cli.main
forbidden_modules = cramlite.cli.resolve
"""


def _lint(config: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", LINT, str(config)]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)


def test_contracts_hold() -> None:
    ran = _lint(ROOT / "pyproject.toml")
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "0 broken" in ran.stdout


def test_a_broken_contract_is_seen(tmp_path: Path) -> None:
    config = tmp_path / "broken.ini"
    config.write_text(BROKEN)
    assert "1 broken" in _lint(config).stdout
