"""Errors about steps that a backend's language cannot express; they name the step, the reason, and a backend
that can."""

from __future__ import annotations

from cramlite.model import AnyStep, Drive, Program, walk
from cramlite.plugin import UserError


def unsupported_step(step: AnyStep, language: str, why: str = "") -> UserError:
    """Make the error about a step that a language cannot express, with the reason.

    Args:
        why: in a clause; what the language lacks, by default.
    """
    kind = type(step).__name__
    why = why or f"{language} has no {kind} here"
    return UserError(f"step '{step.origin or kind}': {why}; write the program as typed_json, which can express every step")


def refuse_drives(program: Program, language: str) -> None:
    """Refuse a program that drives a platform, for a language that moves an arm only.

    Raises:
        UserError: the program drives a platform.
    """
    if drive := next((s for s in walk(program.steps) if isinstance(s, Drive)), None):
        raise unsupported_step(drive, language, f"it drives a platform, and {language} moves an arm only")
