"""Shipped scenarios as a user runs and changes them: the command line in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def cramlite(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a command."""
    command = [sys.executable, "-m", "cramlite", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def changed(scenario: Path, folder: Path, *changes: tuple[str, str]) -> Path:
    """A shipped scenario with some text replaced; each replacement must change something."""
    text = scenario.read_text().replace("demonstration: ", f"demonstration: {scenario.parent}/", 1)
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    path = folder / "variant.yaml"
    path.write_text(text)
    return path
