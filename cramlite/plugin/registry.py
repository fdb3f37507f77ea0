"""Registry of plugins: loads, orders, isolates and asks them; the only module that uses pluggy."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import pluggy
from msgspec import Struct, field

from ..base.errors import DEFECTS, PluginError, Unresolvable, UserError, nearest
from ..base.pulse import checkpoint
from ..base.value import Value
from . import hookspecs
from .entry_points import GROUP, OWN_DISTRIBUTION, Point, entry_points, module_from
from .source_trees import unknown_plugins
from .validation import (
    DECLARING,
    NAMED_BY,
    check_answer,
    check_declared,
    check_hooks,
    check_many,
    error_with_location,
    why_not_loaded,
)


class PluginInfo(Value):
    """Name, origin and state of a plugin, for ``cramlite plugins`` and for messages."""

    name: str
    distribution: str
    version: str
    file: str
    hooks: tuple[str, ...]
    load_ms: float
    fault: str = ""


class Fault(Value):
    """Defect of a plugin, with its place and error."""

    plugin: str
    version: str
    hook: str
    designator: str
    error: str

    def __str__(self) -> str:
        version = f" {self.version}" if self.version else ""  # a file has none
        return f"plugin '{self.plugin}'{version}, hook {self.hook}, at {self.designator or 'load'}: {self.error}"


class _Manager(pluggy.PluginManager):
    """Manager that finds functions marked with ``hookimpl`` faster than pluggy's base class.

    Its search of types and metaclasses for every name of a module was 6 to 9 % of the profile of ``cramlite
    check``.
    """

    def parse_hookimpl_opts(self, plugin: object, name: str) -> pluggy.HookimplOpts | None:
        found = getattr(plugin, name, None)
        return getattr(found, f"{GROUP}_impl", None) if isinstance(found, FunctionType) else None


class Registry(Struct, dict=True):
    """Registry of the plugins of one engine; registries share no state.

    Args:
        files: plugin modules to load by path, before all others.
        blocked: names of plugins that are not loaded, be they installed or in a file.
        preferred: names of plugins that are asked first.
        strict: a file that cannot be used is input of whoever named it. False: recorded like an installed plugin that
            cannot be, which is what ``cramlite plugins`` lists.
        models: libraries of known kinds, which the engine asks plugins to read.

    Raises:
        UserError: a file or a name that there is not, or, if strict, a file that cannot be used.
    """

    files: tuple[Path, ...] = ()
    blocked: tuple[str, ...] = ()
    preferred: tuple[str, ...] = ()
    strict: bool = True
    infos: list[PluginInfo] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)
    models: tuple[Path, ...] = ()

    def __post_init__(self) -> None:
        self._manager = _Manager(GROUP)
        self._manager.add_hookspecs(hookspecs)
        points = entry_points()
        installed = {p.name: p for p in points}
        self._check_names(installed.keys() | {f.stem for f in self.files})
        for file in self.files:
            if not file.is_file():
                raise UserError(f"There is no plugin file '{file}'; give the path of a Python module with --plugin.")
            self._load_file(file, installed.get(file.stem))
        for point in points:
            if point.name not in self.blocked:
                self._load(point.name, point.load, point.distribution, point.version, point.value, point.outdated())

    def _check_names(self, known: set[str]) -> None:
        for name in (*self.blocked, *self.preferred):
            if name not in known:
                raise UserError(f"There is no plugin '{name}' to block or prefer; {nearest(name, known)}.")
        for name in self.blocked:
            if name in self.preferred:
                raise UserError(f"The plugin '{name}' is both blocked and preferred; leave one of them out.")

    def _load_file(self, file: Path, installed: Point | None) -> None:
        """Load a plugin file, unless the user blocked a plugin of its name.

        A file with an installed plugin's name is refused, since blocking that name would leave out both.
        """
        if file.stem in self.blocked and installed is None:
            return
        fault = "" if installed is None else installed.taken()
        self._load(file.stem, lambda: module_from(file), "file", "", str(file), fault)
        if self.strict:
            self._refuse(file)

    def _refuse(self, file: Path) -> None:
        """Raise UserError if the plugin file that was loaded last cannot be used, or has a wrong
        declaration."""
        for hook in [] if self.faults else [h for h in DECLARING if h in self.infos[-1].hooks]:
            for _ in self.collect(hook):
                pass
        if self.faults:
            where = "" if self.faults[0].hook == "import" else f"hook {self.faults[0].hook}: "
            raise UserError(
                f"The plugin file '{file}' cannot be used: {where}{self.faults[0].error}. Correct the file, or leave it out."
            )

    def _load(
        self, name: str, load: Callable[[], Any], distribution: str, version: str, place: str, fault: str = ""
    ) -> None:
        """Load one plugin; an error is recorded as its fault, and the other plugins are loaded all the
        same."""
        begin = time.perf_counter()
        hooks: tuple[str, ...] = ()
        fault = fault or self._same_name(name, distribution, place)
        if not fault:
            try:
                module = load()
                check_hooks(module)
                self._manager.register(module, name)
                hooks = tuple(sorted(h.name for h in self._manager.get_hookcallers(module) or ()))
                fault = "" if hooks else "it has no hook: no function in it is marked with '@hookimpl'"
                place = getattr(module, "__file__", None) or place
            except DEFECTS as error:
                fault = why_not_loaded(error, distribution)
        if fault:
            self.faults.append(Fault(name, version, "import", "", fault))
        elapsed = (time.perf_counter() - begin) * 1000
        self.infos.append(PluginInfo(name, distribution, version, place, hooks, elapsed, fault))

    def include(self, module: ModuleType) -> None:
        """Load a plugin from an imported module, beside those that are installed."""
        self._load(module.__name__, lambda: module, "module", "", module.__name__)

    def _same_name(self, name: str, distribution: str, place: str) -> str:
        """Return a message if a plugin of this name is loaded already, so that the new one is rejected; else ""."""
        first = next((i for i in self.infos if i.name == name and not i.fault), None)
        if first is None:
            return ""
        return (
            f"two plugins are called '{name}': this one, of {distribution} ({place}), and one of {first.distribution} "
            f"({first.file}), which was found first and is used; rename one"
        )

    def _implementations(self, hook: str) -> list[Any]:
        """Return the implementations of a hook: preferred plugins first, then plugin files, third parties,
        and shipped plugins, each in load order."""
        order = {info.name: k for k, info in enumerate(self.infos)}
        own = {info.name for info in self.infos if info.distribution == OWN_DISTRIBUTION}
        impls = getattr(self._manager.hook, hook).get_hookimpls()
        return sorted(
            impls, key=lambda i: (i.plugin_name not in self.preferred, i.plugin_name in own, order[i.plugin_name])
        )

    def collect(self, hook: str) -> Iterator[tuple[str, Any]]:
        """Yield (plugin name, object) for everything that plugins declare under a hook; a broken plugin is
        skipped and recorded as faulty."""
        for impl in self._implementations(hook):
            try:
                answers = list(check_many(hook, impl.function()))
                for answer in answers:
                    check_declared(hook, answer)
            except DEFECTS as error:
                self.fault(impl.plugin_name, hook, "", error)
                continue
            yield from ((impl.plugin_name, answer) for answer in answers)

    def left_out(self, hook: str) -> Iterator[Any]:
        """Yield the declarations that blocked shipped plugins would have made under a hook; no other plugin
        is loaded for this."""
        for point in entry_points() if self.blocked else ():
            if point.name in self.blocked and point.distribution == OWN_DISTRIBUTION and point.defines(hook):
                yield from getattr(point.load(), hook)()

    def unheard(self, hook: str) -> Iterator[Fault]:
        """Yield the faults that kept plugins from declaring under a hook; complete only after that hook was
        collected."""
        lost = {f.plugin for f in self.faults if f.hook == "import"}
        would = {p.name for p in entry_points() if p.name in lost and p.defines(hook)} if lost else set()
        for fault in self.faults:
            if (fault.hook == hook and not fault.designator) or (fault.hook == "import" and fault.plugin in would):
                yield fault

    def examine(self) -> None:
        """Collect the declarations of all plugins, so that ``faults`` lists their errors, name conflicts
        included.

        What a source tree declares and its installation does not know is a fault, too: no other command looks for that.
        """
        for u in unknown_plugins():
            if u.name not in {*self.blocked, *(i.name for i in self.infos)}:
                self._load(u.name, lambda: None, u.distribution, u.version, str(u.file), u.reason)
        list(self.collect("ontologies"))  # which have no names
        for hook, (key, *_) in NAMED_BY.items():
            first: dict[str, str] = {}
            for plugin, item in self.collect(hook):
                own = (
                    (item.task, item.task.split(":")[-1], *item.aliases)
                    if hook == "task_types"
                    else (getattr(item, key),)
                )
                for name in dict.fromkeys(own):
                    if hook != "report_sections" and first.setdefault(name, plugin) != plugin:
                        said = f"plugin '{first[name]}' declares '{name}' too; block one of them, or rename it"
                        self.faults.append(Fault(plugin, self._version(plugin), hook, name, said))

    def _version(self, plugin: str) -> str:
        return next((i.version for i in self.infos if i.name == plugin), "?")

    def named(self, hook: str, key: str) -> Mapping[str, Any]:
        """Return name -> declared object of a hook; the name is the object's ``key`` attribute.

        Raises:
            PluginError: two plugins declare one name; both are named.
        """
        return {name: item for name, (_, item) in self.owned(hook, key).items()}

    def owned(self, hook: str, key: str) -> Mapping[str, tuple[str, Any]]:
        """Return a dictionary from name to (plugin, object) of what a hook declares; the name is the object's attribute ``key``.

        What a preferred plugin declares stands for what another one declares under the same name.

        Raises:
            PluginError: two plugins declare one name; both are named.
        """
        found: dict[str, tuple[str, Any]] = {}
        for plugin, item in self.collect(hook):
            name = getattr(item, key)
            if name in found and found[name][0] in self.preferred and plugin not in self.preferred:
                continue
            if name in found:
                raise PluginError(
                    f"Plugins '{found[name][0]}' and '{plugin}' both declare {hook.removesuffix('s')} '{name}'. "
                    f"Names must be unique: block one with --block {plugin}, or rename it."
                )
            found[name] = (plugin, item)
        return found

    def first(self, hook: str, **arguments: Any) -> Any:
        """Return the first answer of a hook that is not None.

        A ``UserError`` of a plugin is raised; its bugs and wrong answers are recorded as its faults.
        """
        about = next(iter(arguments.values()), "")
        about = str(about) if isinstance(about, str | Path) else getattr(about, "name", "")
        for impl in self._implementations(hook):
            try:
                answer = impl.function(*[arguments[a] for a in impl.argnames])
                if answer is None:
                    continue
                check_answer(hook, answer)
            except UserError:
                raise
            except DEFECTS as error:
                self.fault(impl.plugin_name, hook, about, error)
                continue
            return answer
        return None

    def alternatives(
        self, hook: str, designator: Any, **arguments: Any
    ) -> Iterator[tuple[str, Iterable[Any] | Unresolvable]]:
        """Yield (plugin, answers) for each plugin that does not return None for a designator; answers are
        computed when needed."""
        name = getattr(designator, "name", str(designator))
        for impl in self._implementations(hook):
            values = [arguments.get(a, designator) for a in impl.argnames]
            yield from self.ask(impl.plugin_name, hook, name, partial(impl.function, *values))

    def ask(
        self, plugin: str, hook: str, name: str, question: Callable[[], Iterable[Any] | None]
    ) -> Iterator[tuple[str, Iterable[Any] | Unresolvable]]:
        """Yield a plugin with its answers about a designator, which are computed when needed; nothing if the plugin
        returns None.

        Args:
            name: of the designator that it is asked about.
        """
        checkpoint()
        try:
            answer = question()
            if answer is not None:
                check_many(hook, answer)
        except UserError:
            raise
        except Unresolvable as impossible:
            yield plugin, impossible
            return
        except DEFECTS as error:
            self.fault(plugin, hook, name, error)
            return
        if answer is not None:
            yield plugin, self.guarded(plugin, hook, name, answer)

    def guarded(self, plugin: str, hook: str, designator: str, answers: Iterable[Any]) -> Iterator[Any]:
        """Yield the answers of one plugin; a bug while yielding ends only that plugin's answers."""
        try:
            for answer in answers:
                checkpoint()
                yield answer
        except (Unresolvable, UserError, GeneratorExit):
            raise
        except DEFECTS as error:
            self.fault(plugin, hook, designator, error)

    def notify(self, hook: str, about: str, **arguments: Any) -> None:
        """Call a hook of every plugin and ignore the answers.

        Args:
            about: what a fault is said to be at.
        """
        for impl in self._implementations(hook):
            try:
                impl.function(*[arguments[a] for a in impl.argnames])
            except DEFECTS as error:
                self.fault(impl.plugin_name, hook, about, error)

    def owner(self, hook: str, name: str) -> str:
        """Return which plugin declares the object ``name`` under a hook; ``name`` itself if no plugin does."""
        key = NAMED_BY[hook][0]
        return next((plugin for plugin, item in self.collect(hook) if getattr(item, key) == name), name)

    def fault(self, plugin: str, hook: str, designator: str, error: BaseException) -> Fault:
        """Record a plugin's bug, with the place in the plugin's code."""
        fault = Fault(plugin, self._version(plugin), hook, designator, error_with_location(error))
        if fault not in self.faults:
            self.faults.append(fault)
        return fault
