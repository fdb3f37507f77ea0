"""Validation of plugins before their answers are used, with messages for the users of the plugins."""

from __future__ import annotations

import importlib.metadata
import inspect
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

from ..base.errors import nearest
from ..version import VERSION
from . import hookspecs

NAMED_BY: Mapping[str, tuple[str, ...]] = {
    "task_types": ("task", "decompose"),
    "predicates": ("name", "function"),
    "experts": ("name", "run"),
    "robots": ("type", "mjcf"),
    "object_models": ("name", "make"),
    "simulators": ("name", "execute"),
    "record_scripts": ("name", "prepare"),
    "episode_repairs": ("name", "repair", "order"),
    "location_kinds": ("name", "ground", "summary", "parameters", "gives", "misfit"),
    "motion_kinds": ("name", "knows"),
    "validators": ("name", "check", "cost"),
    "backends": ("name", "emit", "executable"),
    "report_sections": ("title", "render", "order"),
    "exporters": ("name", "write", "suffix"),
}
"""Hook -> required attributes of its declarations: name, functions, and others."""
DECLARING = ("ontologies", *NAMED_BY)
"""Hooks by which plugins make declarations, called once when a plugin is loaded."""

_MANY, _NUMBER = (tuple, list, frozenset), (int, float)
_TYPES: Mapping[str, Mapping[str, tuple[type, ...]]] = {
    "task_types": {"aliases": _MANY, "roles": _MANY, "parameters": _MANY},
    "predicates": {"arity": (int,), "phases": _MANY, "value": (bool,), "cost": _NUMBER},
    "validators": {"cost": (str,), "may_advise": (bool,)},
    "experts": {"scope": (str,), "inputs": _MANY, "outputs": _MANY, "uses": _MANY, "cost_ms": _NUMBER, "parameters": _MANY},
    "robots": {"axis_zeros": _MANY, "controller": (str,), "force_limit": _NUMBER},
    "object_models": {"files": _MANY, "product": (bool,)},
    "backends": {"executable": (bool,), "typed_stands_in": (bool,)},
    "episode_repairs": {"order": _NUMBER},
    "report_sections": {"order": _NUMBER, "refused": (bool,)},
    "exporters": {"suffix": (str,), "about": (str,), "needs": (dict,)},
}
"""Hook -> attributes with their accepted types, which are checked since a wrong type would be noticed late or never: a text, for
example, is also a sequence of letters, and true."""


class NoModule(Exception):
    """Error: a file that was given as a plugin is no Python module."""


class WrongHook(Exception):
    """Error: a function marked as a hook is no hook, or takes arguments that the hook does not have."""


class WrongDeclaration(Exception):
    """Error: a declaration under a hook is of the wrong kind."""


class WrongAnswer(Exception):
    """Error: a plugin's answer has the wrong type or contents."""


def check_hooks(plugin: ModuleType | object) -> None:
    """Check that every function marked with ``hookimpl`` is named after a hook and takes only the hook's
    arguments.

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
    """Check that a declaration has the members that its hook needs.

    Raises:
        WrongDeclaration: names what it has not, or what of it is not possible.
    """
    if hook == "ontologies":
        _check_path(item)
        return
    for attribute in NAMED_BY.get(hook, ()):
        if not _worked_out(item, attribute) and not hasattr(item, attribute):
            what = (
                f"the class {item.__name__}; declare an instance, {item.__name__}()"
                if isinstance(item, type)
                else repr(item)
            )
            raise WrongDeclaration(f"{hook} gave {what[:80]}, which has no '{attribute}'")
    if isinstance(item, type):
        raise WrongDeclaration(f"{hook} gave the class {item.__name__}; declare an instance, {item.__name__}()")
    if hook in NAMED_BY:
        _check_complete(hook, item)
        _check_values(hook, item)


def _check_complete(hook: str, item: object) -> None:
    """Check that a declaration has all members that the engine uses, whatever its class is."""
    kind = _class_of(hook)
    if kind is None or isinstance(item, kind):
        return
    wanted: Iterable[str] = getattr(kind, "__struct_fields__", None) or [n for n in dir(kind) if not n.startswith("_")]
    for name in wanted:
        if not _worked_out(item, name) and not hasattr(item, name):
            raise WrongDeclaration(f"{hook} gave {_short(item)}, which has no '{name}'; use the class {kind.__name__}")


def _class_of(hook: str) -> type | None:
    """Return the class that declarations under a hook should have; None if any object with the members will
    do."""
    if hook == "task_types":
        from .task_type import TaskType

        return TaskType
    if hook == "record_scripts":
        from .demonstration import RecordScript

        return RecordScript
    if hook == "location_kinds":
        from .location_kind import LocationKind

        return LocationKind
    if hook == "motion_kinds":
        from .motion_kind import MotionKind

        return MotionKind
    if hook == "robots":
        from ..model.robot import Robot

        return Robot
    from . import protocols

    kinds = {"object_models": "ModelMaker", "episode_repairs": "EpisodeRepair", "exporters": "Exporter", "report_sections": "ReportSection"}
    return getattr(protocols, kinds[hook]) if hook in kinds else None


def _check_path(item: object) -> None:
    if not isinstance(item, Path | str):
        raise WrongDeclaration(f"ontologies gave {_short(item)}, which is no path")
    if not Path(item).exists():
        raise WrongDeclaration(f"ontologies gave '{item}', and there is no such file; write Path(__file__).parent / 'NAME.ttl'")


def check_many(hook: str, answer: Any) -> Iterable[Any]:
    """Check that the answer of a hook is a list or another iterable, and return it.

    Raises:
        WrongAnswer: it is none; names what it is.
    """
    if not isinstance(answer, Iterable) or isinstance(answer, str):
        raise WrongAnswer(f"{hook} gave {_short(answer)}; it must give a list, empty where there is nothing, or yield")
    return answer


def check_answer(hook: str, answer: object) -> None:
    """Check that the answer of a hook has the hook's type, or is None.

    Raises:
        WrongAnswer: it has not; names what it is, or what is in it that does not belong there.
    """
    wanted = _answer_type(hook)
    if not isinstance(answer, wanted):
        raise WrongAnswer(f"{hook} gives {wanted.__name__}, not {_short(answer)}")
    if wanted.__name__ == "Episode":
        _check_episode(hook, answer)


def _answer_type(hook: str) -> type:
    if hook == "read_view":
        from ..model.view import View

        return View
    if hook == "add_models":
        from ..model.world.known_kind import BuiltLibrary

        return BuiltLibrary
    if hook == "read_scene":
        from ..model.world.imported_scene import ImportedScene

        return ImportedScene
    if hook == "read_robot":
        from ..model.imported_robot import ImportedRobot

        return ImportedRobot
    if hook in ("read_episode", "detect_events", "episode_repairs"):
        from ..model.episode import Episode

        return Episode
    return {"write_episode": Path, "episode_triples": Iterable, "read_models": Sequence, "read_sentence": list}[hook]


def _check_episode(hook: str, episode: Any) -> None:
    from ..model.episode import Entity, Event, Track

    tracks = tuple(episode.tracks.values()) if isinstance(episode.tracks, Mapping) else episode.tracks
    parts = {"entities": (episode.entities, Entity), "events": (episode.events, Event), "tracks": (tracks, Track)}
    for name, (values, kind) in parts.items():
        for value in values if isinstance(values, _MANY) else (values,):
            if not isinstance(value, kind):
                raise WrongAnswer(f"{hook} gives an Episode whose '{name}' have {_short(value)}, which is no {kind.__name__}")


def _check_values(hook: str, item: object) -> None:
    """Check the types of a declaration's attributes, and that words in them, such as a cost class, are known
    to the engine.

    An unknown word would be ignored silently.
    """
    key, does, *_ = NAMED_BY[hook]
    name = getattr(item, key)
    if not isinstance(name, str) or not name:
        raise WrongDeclaration(f"{hook} gave {repr(item)[:80]}, whose '{key}' is {name!r}; it must be text")
    if not callable(getattr(item, does)):
        raise WrongDeclaration(f"{hook} gave '{name}', whose '{does}' is {_short(getattr(item, does))}; it must be a function")
    for attribute, types in _TYPES.get(hook, {}).items():
        value = None if _worked_out(item, attribute) else getattr(item, attribute, None)
        if value is not None and not isinstance(value, types):
            valid = {"tuple": "a tuple", "bool": "True or False", "str": "one word"}.get(types[0].__name__, "a number")
            raise WrongDeclaration(f"{hook} gave '{name}', whose '{attribute}' is {_short(value)}; it must be {valid}")
    for attribute, words in _words(hook).items():
        said = getattr(item, attribute)
        for word in said if isinstance(said, _MANY) else (said,):
            if word not in words:
                raise WrongDeclaration(
                    f"{hook} gave '{name}', whose '{attribute}' is {_short(word)}; {nearest(str(word), words)}"
                )
    if hook == "predicates":
        _check_fluent(name, item)


def _check_fluent(name: str, item: object) -> None:
    """Check that a predicate's planning fields have their types."""
    from ..interpretation.fluents import Fluent

    static, fluent = getattr(item, "static", None), getattr(item, "fluent", Fluent())
    if static is not None and not callable(static):
        raise WrongDeclaration(f"predicates gave '{name}', whose 'static' is {_short(static)}; it must be a function")
    if not isinstance(fluent, Fluent):
        raise WrongDeclaration(f"predicates gave '{name}', whose 'fluent' is {_short(fluent)}; it must be a Fluent")
    if fluent.contrary is not None and not callable(fluent.contrary):
        raise WrongDeclaration(f"predicates gave '{name}', whose fluent's 'contrary' is {_short(fluent.contrary)}; it must be a function")
    for attribute in ("implies", "implies_when_carried", "undoes", "excludes", "denial", "phrases"):
        if not isinstance(getattr(fluent, attribute), _MANY):
            said = f"whose fluent's '{attribute}' is {_short(getattr(fluent, attribute))}; it must be a tuple"
            raise WrongDeclaration(f"predicates gave '{name}', {said}")


def _worked_out(item: object, attribute: str) -> bool:
    """Check whether an attribute is a property, which is not evaluated here, because that may import many
    modules."""
    return isinstance(getattr(type(item), attribute, None), property)


def _short(value: object) -> str:
    return repr(value)[:80]


def _words(hook: str) -> Mapping[str, tuple[str, ...]]:
    """Return attribute -> valid words, for the attributes of a hook's declarations that have a fixed set."""
    if hook == "validators":
        from ..model.run.verdict import COSTS

        return {"cost": COSTS}
    if hook == "experts":
        from .expert import Scope

        return {"scope": get_args(Scope)}
    if hook == "predicates":
        from ..interpretation.timeline import PhaseName

        return {"phases": get_args(PhaseName)}
    return {}


def why_not_loaded(error: BaseException, distribution: str) -> str:
    """Explain why a plugin could not be imported, with the next step."""
    if isinstance(error, ModuleNotFoundError) and error.name:
        package = error.name.split(".")[0]
        if package in ("cramlite", "cramlite_plugins"):
            return (
                f"it imports '{error.name}', which cramlite {VERSION} does not have; it was written for another version"
            )
        return f"the plugin needs the package '{package}', which is not installed here; install it, or leave the plugin out with --block"
    if isinstance(error, ImportError) and error.name and error.name.split(".")[0] == "cramlite":
        return f"{error}; it was written for another version than cramlite {VERSION}"
    if isinstance(error, SystemExit):
        return f"the plugin ends the process when it is imported (exit {error.code}); a plugin only declares at import"
    if isinstance(error, SyntaxError):
        return f"line {error.lineno} is no Python: {error.msg}" if error.lineno else f"it is no Python text: {error.msg}"
    return error_with_location(error)


def error_with_location(error: BaseException) -> str:
    """Return an error's text with the file and line where it arose.

    Objections of the engine itself to a plugin have neither.
    """
    if isinstance(error, NoModule | WrongHook | WrongDeclaration | WrongAnswer):
        return str(error)
    trace, place = error.__traceback__, ""
    while trace is not None:
        file = trace.tb_frame.f_code.co_filename
        if not file.startswith("<frozen"):
            place = f" ({Path(file).name}:{trace.tb_lineno})"
        trace = trace.tb_next
    return f"{type(error).__name__}: {error}{place}"


def made_for_another_version(distribution: importlib.metadata.Distribution) -> str:
    """Explain by a distribution's metadata why it is not made for this cramlite version; "" if it is."""
    from packaging.requirements import InvalidRequirement, Requirement

    for text in distribution.requires or ():
        if not re.match(r"cramlite\b(?![-_.])", text, re.IGNORECASE):
            continue
        try:
            wanted = Requirement(text)
        except InvalidRequirement:
            return f"'{text}' in the plugin's metadata is no valid requirement; the plugin's author has to correct it"
        if not wanted.specifier.contains(VERSION, prereleases=True):
            return (
                f"it was made for cramlite{wanted.specifier}, and this is {VERSION}; update it with "
                f"'pip install --upgrade {distribution.name}', or ask its author"
            )
    return ""
