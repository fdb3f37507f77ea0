"""What can be wrong with a plugin before it is asked anything, in words for the person who has it installed."""

from __future__ import annotations

import importlib.metadata
import inspect
import re
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType

from . import hookspecs
from .errors import nearest
from .version import VERSION

NAMED_BY: Mapping[str, tuple[str, ...]] = {
    "task_types": ("task", "decompose"),
    "predicates": ("name", "function"),
    "experts": ("name", "run"),
    "robots": ("type", "mjcf"),
    "object_models": ("name", "make"),
    "simulators": ("name", "execute"),
    "validators": ("name", "check"),
    "backends": ("name", "emit"),
    "report_sections": ("title", "render"),
}
"""Hook -> what the things declared under it have: their name and what they do."""


class NoModule(Exception):
    """A file that was given as a plugin and is no Python module."""


class WrongHook(Exception):
    """A function that is marked as a hook and is none, or takes arguments that the hook does not have."""


class WrongDeclaration(Exception):
    """Something declared under a hook that is not what the hook is for."""


def check_hooks(plugin: ModuleType | object) -> None:
    """Every function marked with ``hookimpl`` is a hook, and takes only arguments that it has.

    Raises:
        WrongHook: names the function, what is wrong, and the nearest right name.
    """
    hooks = {n: f for n, f in vars(hookspecs).items() if hasattr(f, "cramlite_spec")}
    for name in dir(plugin):
        function = getattr(plugin, name, None)
        if not hasattr(function, "cramlite_impl"):
            continue
        if name not in hooks:
            raise WrongHook(f"there is no hook '{name}'; {nearest(name, hooks)}")
        valid = list(inspect.signature(hooks[name]).parameters)
        for given in inspect.signature(function).parameters:  # type: ignore[arg-type]
            if given not in valid:
                has = f"{nearest(given, valid)}" if valid else "it takes none"
                raise WrongHook(f"hook '{name}' has no argument '{given}'; {has}")


def check_declared(hook: str, item: object) -> None:
    """A declared thing has what its hook is for.

    Raises:
        WrongDeclaration: names what it has not.
    """
    for attribute in NAMED_BY.get(hook, ()):
        if not hasattr(item, attribute):
            what = (
                f"the class {item.__name__}; declare an instance, {item.__name__}()"
                if isinstance(item, type)
                else repr(item)
            )
            raise WrongDeclaration(f"{hook} gave {what[:80]}, which has no '{attribute}'")
    if isinstance(item, type):
        raise WrongDeclaration(f"{hook} gave the class {item.__name__}; declare an instance, {item.__name__}()")


def why_not_loaded(error: BaseException, distribution: str) -> str:
    """Why a plugin could not be imported, and what to do."""
    if isinstance(error, ModuleNotFoundError) and error.name:
        package = error.name.split(".")[0]
        if package in ("cramlite", "cramlite_plugins"):
            return (
                f"it imports '{error.name}', which cramlite {VERSION} does not have; it was written for another version"
            )
        return f"it needs the package '{package}', which is not installed here; install it, or leave the plugin out with --block"
    if isinstance(error, ImportError) and error.name and error.name.split(".")[0] == "cramlite":
        return f"{error}; it was written for another version than cramlite {VERSION}"
    if isinstance(error, SystemExit):
        return f"it ends the process when it is imported (exit {error.code}); a plugin declares, and does nothing at import"
    if isinstance(error, WrongHook | NoModule):
        return str(error)
    if isinstance(error, SyntaxError):
        return f"line {error.lineno} is no Python: {error.msg}" if error.lineno else f"it is no Python text: {error.msg}"
    return said_with_place(error)


def said_with_place(error: BaseException) -> str:
    """An error with the place in a file at which it was raised."""
    trace, place = error.__traceback__, ""
    while trace is not None:
        file = trace.tb_frame.f_code.co_filename
        if not file.startswith("<frozen"):
            place = f" ({Path(file).name}:{trace.tb_lineno})"
        trace = trace.tb_next
    return f"{type(error).__name__}: {error}{place}"


def made_for_another_version(distribution: importlib.metadata.Distribution) -> str:
    """Why a distribution is not for this version, by the versions of cramlite that its metadata asks for; empty if it is."""
    from packaging.requirements import InvalidRequirement, Requirement

    for text in distribution.requires or ():
        if not re.match(r"cramlite\b(?![-_.])", text, re.IGNORECASE):
            continue
        try:
            wanted = Requirement(text)
        except InvalidRequirement:
            return f"'{text}' in its metadata is no requirement; its author has to correct it"
        if not wanted.specifier.contains(VERSION, prereleases=True):
            return (
                f"it was made for cramlite{wanted.specifier}, and this is {VERSION}; update it with "
                f"'pip install --upgrade {distribution.name}', or ask its author"
            )
    return ""
