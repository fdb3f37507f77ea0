"""Knowledge of an engine, collected from its plugins: task types, robots, object models, backends, validators, classes, rules."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from copy import copy
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from ..base.errors import PluginError, UserError, nearest
from ..base.resources import data_folder
from ..model.geometry import Pose
from .protocols import Driver

if TYPE_CHECKING:
    from ..interpretation.rules import Rule
    from ..interpretation.timeline import Predicate
    from ..model.imported_robot import ImportedRobot
    from ..model.robot import Robot
    from ..model.robot_file import RobotFile
    from ..model.run.readings import Watch
    from ..model.run.rollout import Rollout
    from ..model.world.thing import Thing
    from ..model.world.world import World
    from ..ontology.taxonomy import Taxonomy
    from .demonstration import RecordScript
    from .episode_hooks import EpisodeHooks
    from .expert import Expert
    from .location_kind import LocationKind
    from .motion_kind import MotionKind
    from .protocols import Backend, Exporter, ModelMaker, Simulator, Validator
    from .registry import Registry
    from .task_type import TaskType


class Knowledge:
    """Declarations of all plugins of one registry, such as robots; those of each sort are collected at their first use.

    Args:
        registry: whose plugins are asked.
        ontologies: further ontology files, beside the shipped ones and those of plugins.
        rules: a folder of rule files that stands for the shipped ones and those of plugins.
    """

    def __init__(self, registry: Registry, ontologies: Iterable[Path] = (), rules: Path | None = None) -> None:
        self.registry = registry
        self._ontologies, self._rules = tuple(ontologies), rules
        self._read: dict[object, ImportedRobot] = {}

    @cached_property
    def task_owners(self) -> Mapping[str, str]:
        """Task class -> name of the plugin that declares it; names and aliases of tasks are unique."""
        owners: dict[str, str] = {}
        for plugin, task in self.registry.collect("task_types"):
            for name in (task.task, task.task.split(":")[-1], *task.aliases):
                if owners.get(name, plugin) != plugin:
                    raise PluginError(
                        f"Plugins '{owners[name]}' and '{plugin}' both declare the task name '{name}'. "
                        f"Names must be unique: block one with --block {plugin}, or rename it."
                    )
                owners[name] = plugin
        return owners

    @cached_property
    def tasks(self) -> Mapping[str, TaskType]:
        """Task types of all plugins, by task class."""
        _ = self.task_owners
        return {task.task: task for _, task in self.registry.collect("task_types")}

    @cached_property
    def robots(self) -> Mapping[str, Robot]:
        """Type of a robot -> robot model."""
        return self.registry.named("robots", "type")

    def with_robot(self, robot: Robot) -> Knowledge:
        """Return this knowledge with another model for a robot's type."""
        changed = copy(self)
        changed.__dict__["robots"] = {**self.robots, robot.type: robot}
        return changed

    def robots_of(self, world: World) -> Mapping[str, Robot]:
        """Return robot type -> robot model: those of plugins, and those of a world's robots that are read
        from files.

        Raises:
            UserError: a file cannot be used.
        """
        files = {m.type: self.read_robot(m.file).robot for m in world.robots if m.file is not None}
        return {**self.robots, **files} if files else self.robots

    def read_robot(self, file: RobotFile) -> ImportedRobot:
        """Read a robot with the first plugin that knows its file's format; the result is cached until the
        file changes.

        Its type is the model's name with the file's.

        Raises:
            UserError: no plugin does, or it cannot be used.
            PluginError: the one that should have read it failed.
        """
        path = Path(file.path)
        key = (file, path.stat().st_mtime_ns if path.is_file() else 0)
        if key not in self._read:
            found = self.registry.first("read_robot", file=file, name=path.name)
            if found is None:
                nobody = f"'{path}' is in no format that a plugin reads as a robot (MJCF, URDF); see 'cramlite plugins'."
                failed = [str(f) for f in self.registry.faults if f.hook == "read_robot"]
                raise PluginError(f"{nobody} Failed: {'; '.join(failed)}.") if failed else UserError(nobody)
            self._read[key] = found
        return self._read[key]

    @cached_property
    def models(self) -> Mapping[str, ModelMaker]:
        """Name -> parametric object model, of plugins and of libraries.

        Raises:
            UserError: a library cannot be used, or has a name that another one or a plugin has.
        """
        return self._with_libraries(self.registry.named("object_models", "name"), self.registry.models)

    def models_with(self, libraries: Iterable[Path]) -> Mapping[str, ModelMaker]:
        """Return the object models with those of further libraries, which a scenario names.

        Raises:
            UserError: as ``models``.
        """
        return self._with_libraries(self.models, (p for p in libraries if p not in self.registry.models))

    def _with_libraries(self, models: Mapping[str, ModelMaker], libraries: Iterable[Path]) -> Mapping[str, ModelMaker]:
        found = dict(models)
        for path in libraries:
            for maker in self._library(path):
                if maker.name in found:
                    raise UserError(
                        f"The library '{path}' has an object model '{maker.name}', and there is one of that name already; "
                        "rename the one in the library's file."
                    )
                found[maker.name] = maker
        return found

    def _library(self, path: Path) -> Sequence[ModelMaker]:
        """Return the object models of a library, read by the first plugin that knows its format."""
        found: Sequence[ModelMaker] | None = self.registry.first("read_models", path=path)
        if found is None:
            raise UserError(f"'{path}' is no library of object models; make one with 'cramlite library add FOLDER --out {path}'.")
        return found

    @cached_property
    def record_scripts(self) -> Mapping[str, RecordScript]:
        """Name of a script, or class of the task that it shows -> script of the simulated person."""
        return self.registry.named("record_scripts", "name")

    @cached_property
    def products(self) -> tuple[Thing, ...]:
        """Products that perception can recognise by their look: one thing, at the origin, of each object model that is a product."""
        return tuple(m.make(name=n, pose=Pose()) for n, m in self.models.items() if m.product)

    @cached_property
    def backends(self) -> Mapping[str, Backend]:
        """Name -> backend."""
        return self.registry.named("backends", "name")

    @cached_property
    def driver(self) -> Driver:
        """First declared backend that can also drive a robot through another process."""
        for backend in self.backends.values():
            if isinstance(backend, Driver):
                return backend
        raise UserError("No plugin can drive a robot through another process; see 'cramlite plugins'.")

    @cached_property
    def location_kinds(self) -> Mapping[str, LocationKind]:
        """Name of a relation, such as "on" -> the kind of location that a plugin declares for it."""
        return self.registry.named("location_kinds", "name")

    @cached_property
    def motion_kinds(self) -> Mapping[str, MotionKind]:
        """Name -> kind of motion."""
        return self.registry.named("motion_kinds", "name")

    @cached_property
    def exporters(self) -> Mapping[str, Exporter]:
        """Name -> format that recorded runs can be exported to."""
        return self.registry.named("exporters", "name")

    @cached_property
    def validators(self) -> tuple[Validator, ...]:
        """Validators of programs and rollouts.

        Raises:
            PluginError: a plugin that has some is broken: what they would refuse would pass unseen.
        """
        found = tuple(self.registry.named("validators", "name").values())
        for fault in self.registry.unheard("validators"):
            raise PluginError(
                f"A validator is missing, and without it nothing is proven: {fault}. Mend or reinstall the plugin, or leave it out "
                f"knowingly with --block {fault.plugin}."
            )
        return found

    @cached_property
    def left_out(self) -> tuple[str, ...]:
        """Names of the shipped validators that are not asked, because their plugins are blocked and no other
        plugin replaces them."""
        asked = {v.name for v in self.validators}
        return tuple(v.name for v in self.registry.left_out("validators") if v.name not in asked)

    @cached_property
    def experts(self) -> tuple[Expert, ...]:
        """Perception experts."""
        return tuple(self.registry.named("experts", "name").values())

    @cached_property
    def expert_owners(self) -> Mapping[str, str]:
        """Return a dictionary from each perception expert's name to the name of the plugin that declares the expert."""
        return {expert.name: plugin for plugin, expert in self.registry.collect("experts")}

    @cached_property
    def simulator(self) -> Simulator:
        """First simulator that is declared."""
        for _, simulator in self.registry.collect("simulators"):
            return simulator  # type: ignore[no-any-return]
        raise UserError("No plugin offers a simulator, and nothing can be proven without one; see 'cramlite plugins'.")

    def run(self, text: str, world: World, seed: int, *, mount: str = "", watch: Watch | None = None) -> Rollout:
        """Run a program's text on the controller model in a world.

        Args:
            mount: name of the robot; "" for the world's first one.
            watch: is shown readings, and can stop the run; a simulator without that parameter can run only without one.
        """
        robots, mount = self.robots_of(world), mount or world.robots[0].name
        watching = {} if watch is None else {"watch": watch}
        return self.simulator.execute(text, world, robots, mount=mount, seed=seed, **watching)

    @cached_property
    def episodes(self) -> EpisodeHooks:
        """Access to what plugins do with episodes: read, repair and write them, and detect events in runs."""
        from .episode_hooks import EpisodeHooks

        return EpisodeHooks(self.registry)

    @cached_property
    def ontology_paths(self) -> list[Path]:
        """Ontology files: the shipped ones, those of plugins, and further ones."""
        shipped = sorted(data_folder("ontologies").glob("*.ttl"))
        offered = [Path(path) for _, path in self.registry.collect("ontologies")]
        return [*shipped, *offered, *self._ontologies]

    @cached_property
    def taxonomy(self) -> Taxonomy:
        """Taxonomy of all classes; a plugin's task that no ontology has becomes a subclass of its
        ``TaskType.above``."""
        from ..ontology.taxonomy import load_taxonomy

        found = load_taxonomy(self.ontology_paths)
        new = {name: (task.above,) for name, task in self.tasks.items() if name not in found.classes}
        return replace(found, parents={**found.parents, **new}) if new else found

    @property
    def predicates(self) -> list[Predicate]:
        """Predicates that conditions of rules may use."""
        return [p for _, p in self.registry.collect("predicates")]

    @cached_property
    def rules(self) -> tuple[Rule, ...]:
        """Task rules, sorted by task."""
        from ..interpretation.rules import load_rules

        if self._rules is not None:
            return load_rules([self._rules], self.predicates, self.taxonomy)
        shipped = sorted(data_folder("task_rules").glob("*.yaml"))
        return load_rules([*shipped, *self._own_rule_files()], self.predicates, self.taxonomy)

    def _own_rule_files(self) -> Iterator[Path]:
        """Yield the rule files of plugins; one that cannot be used is left out as its plugin's fault.

        Raises:
            UserError: it is a plugin's that was given as a file, and so is input.
        """
        from ..interpretation.rules import load_rules

        given = {f.stem for f in self.registry.files if self.registry.strict}
        for name, task in self.tasks.items():
            if task.rule_file is None:
                continue
            try:
                load_rules([task.rule_file], self.predicates, self.taxonomy)
            except UserError as error:
                if self.task_owners[name] in given:
                    raise
                self.registry.fault(self.task_owners[name], "task_types", name, error)
            else:
                yield task.rule_file

    @property
    def goal_rules(self) -> tuple[Rule, ...]:
        """Rules in the order in which the search for a goal tries their tasks: those of preferred plugins,
        the shipped ones, all others.

        So where sequences are equally long, the installation of a further plugin changes none of them.
        """
        preferred = self.registry.preferred
        return tuple(
            sorted(self.rules, key=lambda r: (self.task_owners.get(r.task) not in preferred, r.task in self.added_tasks))
        )

    @cached_property
    def added_tasks(self) -> frozenset[str]:
        """Classes of the tasks whose plugins are neither shipped nor preferred."""
        from .entry_points import OWN_DISTRIBUTION

        known = {i.name for i in self.registry.infos if i.distribution == OWN_DISTRIBUTION} | {*self.registry.preferred}
        return frozenset(t for t in self.tasks if self.task_owners[t] not in known)


def pick(kind: str, table: Mapping[str, Any], name: str, where: str = "") -> Any:
    """Look up a name in a table, such as that of all backends.

    Raises:
        UserError: there is none; the nearest valid names are listed.
    """
    if name not in table:
        raise UserError(f"{where + ': ' if where else ''}There is no {kind} '{name}'; {nearest(name, table)}.")
    return table[name]


def examine(registry: Registry) -> None:
    """Collect all that plugins declare, and read their rule files, so that ``registry.faults`` lists every error."""
    registry.examine()
    with suppress(PluginError, UserError):  # of two plugins that clash, which is among the faults already
        _ = Knowledge(registry).rules
