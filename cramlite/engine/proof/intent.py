"""Intent of a program: all that validators must know beside its text, kept in its run directory as ``intent.json``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from msgspec import DecodeError, json

from ...base.errors import UserError
from ...base.value import Value
from ...model.belief import Belief
from ...model.designators import Action
from ...model.handover import Handover
from ...model.plan import Plan
from ...model.program.program import Code, Program
from ...model.program.program_json import read_program
from ...model.run.judging_limits import JudgingLimits
from ...model.world.world import World
from ...plugin.protocols import Candidate

FILE, PROGRAM = "intent.json", "program.json"


class Kept(Value):
    """Content of ``intent.json`` in a run directory: what a proven program is for, and the text that was proven.

    Args:
        plan, actions, parts, belief, world, limits, handovers: as a ``Candidate`` has them.
        bindings: designator name -> entity, those that are bound to one.
        text, language, suffix: as it was proven; of a ``Code``.
        origins: the line that each origin begins at, from 1, and the origin.
    """

    plan: Plan
    actions: tuple[Action, ...]
    parts: tuple[Action, ...]
    belief: Belief
    world: World
    limits: JudgingLimits
    bindings: Mapping[str, str]
    text: str
    language: str
    suffix: str
    origins: tuple[tuple[int, str], ...]
    handovers: tuple[Handover, ...] | None = None

    @property
    def code(self) -> Code:
        """The text that was proven, with the origins of its lines."""
        return Code(self.language, self.text, dict(self.origins), self.suffix)


class Intent(Value):
    """Intent of a run's text: the grounded plan, and the typed program that the text was written from.

    Args:
        kept: what its run directory says of it.
        program: the typed program that the text was written from.
    """

    kept: Kept
    program: Program


def write_intent(candidate: Candidate) -> bytes:
    """Encode the content of ``intent.json``; the same candidate gives the same text."""
    code = candidate.written
    bindings = {k: v for k, v in candidate.bindings.items() if isinstance(v, str)}
    kept = Kept(
        candidate.plan, candidate.actions, candidate.parts, candidate.belief, candidate.world, candidate.limits, bindings,
        code.text, code.language, code.suffix, tuple(sorted(code.origins.items())),
        candidate.handovers,
    )  # fmt: skip
    return json.format(json.encode(kept, enc_hook=_plain, order="deterministic"), indent=1)


def read_intent(run: Path) -> Intent:
    """Read from a run directory what its program is for: the grounded plan and the typed program.

    Raises:
        UserError: the folder holds no such run, or it is damaged.
    """
    try:
        kept = json.decode((run / FILE).read_bytes(), type=Kept)
        return Intent(kept, read_program((run / PROGRAM).read_text(encoding="utf-8")).program)
    except OSError as error:
        raise UserError(
            f"'{run}' does not say what its program is for ({error.strerror}: '{Path(str(error.filename)).name}'); give a "
            "directory that 'cramlite resolve' of this version wrote, with a program that was proven."
        ) from error
    except (DecodeError, UnicodeDecodeError) as error:
        raise UserError(f"'{run / FILE}' is damaged: {error}. Run 'cramlite resolve' again.") from error


def _plain(value: Any) -> Any:
    """Convert a NumPy number or array, which plugins may give as a parameter, to plain Python numbers and
    lists."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
