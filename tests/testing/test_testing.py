"""Every first-party plugin keeps the contract, and the checks see what does not."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Iterable
from pathlib import Path
from types import ModuleType

import pytest
from msgspec.structs import replace

from cramlite.model import Action, Belief, Location, Motion, Program
from cramlite.plugin import Backend, Code, Decomposition, Expert, Parameter, Predicate, Role, TaskType, UserError
from cramlite.plugin.entry_points import GROUP
from cramlite.testing import KINDS, RELATIONS, check_file, check_plugin
from cramlite.testing.plugin_checks import check_backend, check_expert, check_predicate, check_robot, sample_robot
from cramlite.testing.task_checks import check_task_type
from cramlite_plugins.locations.kinds import KINDS as LOCATIONS
from cramlite_plugins.motions.motion_kinds import KINDS as MOTIONS

PLUGINS = sorted(p.value for p in importlib.metadata.entry_points(group=GROUP) if p.dist and p.dist.name == "cramlite")


@pytest.mark.parametrize("module", PLUGINS)
def test_first_party_plugins(module: str) -> None:
    check_plugin(module)


class Fine(TaskType):
    task = "x:Fine"
    summary = "hold still"
    roles = (Role("Patient"),)

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        yield Decomposition((Motion(action.inside("hold"), "hold"),), "hold")


def _variant(**changes: object) -> TaskType:
    variant: TaskType = type("Variant", (Fine,), changes)()
    return variant


def test_a_fine_task() -> None:
    check_task_type(Fine())


def _decompose(*steps: object) -> Callable[..., Iterable[Decomposition]]:
    return lambda self, action, belief: [Decomposition(steps, "x")]  # type: ignore[arg-type]


def _bug(self: TaskType, action: Action, belief: Belief) -> Iterable[Decomposition]:
    raise KeyError("cup")


def _to(relation: str, **parameters: object) -> Callable[..., Iterable[Decomposition]]:
    return _decompose(Motion("1.Fine/go", "linear", Location("place", relation, "cup", parameters)))


def _moving(**parameters: float) -> Callable[..., Iterable[Decomposition]]:
    return _decompose(Motion("1.Fine/go", "until_contact", Location("home", "home"), parameters))


def _role(name: str, *features: str) -> tuple[Role]:
    return (Role(name, features=features),)


def _asks(where: str, name: str) -> Callable[..., Belief]:
    """Effects that ask for a role or parameter."""

    def effects(self: TaskType, action: Action, belief: Belief) -> Belief:
        assert getattr(action, where)[name]
        return belief

    return effects


GRIPS = _decompose(Motion("1.Fine/grip", "gripper"))
SPEED = (Parameter("speed_m_s", 1.0, "measured"),)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"task": "Fine"}, "CURIE"),
        ({"aliases": ("Fine",)}, "names repeat"),
        ({"summary": ""}, "summary"),
        ({"effects": lambda self, action, belief: None}, "effects must give a Belief, not None"),
        ({"decompose": _decompose(Motion("1.Fine/go", "linear", Location("home", "home"), may_touch="cup"))}, "a tuple of names"),  # type: ignore[arg-type]
        ({"roles": (Role("the thing"),)}, "one capitalised word"),
        ({"roles": _role("A", "vrps:SurfaceFeeture")}, "role 'A'.*unknown class 'vrps:SurfaceFeeture'.*did you mean 'vrps:SurfaceFeature'"),
        ({"roles": (Role("A", types="dul:Agent"),)}, "types must be a tuple of classes"),  # type: ignore[arg-type]
        ({"decompose": _to("onn")}, "no plugin answers the relation 'onn'; did you mean 'on'"),
        ({"decompose": _to("lift", heigth_m=0.1)}, "'lift' has no parameter 'heigth_m'; did you mean 'height_m'"),
        ({"decompose": _to("lift", height_m="high")}, "'height_m' of the relation 'lift': expected `float`, got `str`"),
        ({"decompose": _to("lift")}, "'lift' needs the parameter 'height_m'"),
        ({"decompose": _moving(force=3.0)}, "'until_contact' has no parameter 'force'; did you mean 'force_n'"),
        ({"effects": _bug}, "effects raised KeyError\\('cup'\\)"),
        ({"effects": lambda self, action, belief: belief.nothing}, "effects raised AttributeError"),
        ({"effects": _asks("roles", "Patent")}, "asks for a role 'Patent'; did you mean 'Patient'"),
        ({"effects": _asks("parameters", "speed_m_s"), "parameters": SPEED}, "self.parameter\\(action, 'speed_m_s'\\)"),
        ({"rule_file": Path("/nowhere.yaml")}, "no rule file '/nowhere.yaml'"),
        ({"roles": (Role("A"), Role("A"))}, "roles repeat"),
        ({"parameters": (Parameter("speed_m_s", 1.0, ""),)}, "where its default comes from"),
        ({"decompose": _bug}, "the only exception that it may raise"),
        ({"decompose": _decompose(Motion("a", "levitate"))}, "levitate"),
        ({"decompose": _decompose("grasp it")}, "no designator"),
        ({"decompose": _decompose(Motion("a", "hold"), Motion("a", "hold"))}, "share a name"),
        ({"decompose": lambda self, action, belief: []}, "neither"),
    ],
)
def test_what_breaks_the_contract(changes: dict[str, object], says: str) -> None:
    with pytest.raises(AssertionError, match=says):
        check_task_type(_variant(**changes))


@pytest.mark.parametrize(
    "changes",
    [
        {"roles": _role("Patient", "vrps:SurfaceFeature")},
        {"decompose": _to("on")},
        {"decompose": _to("lift", height_m=0.1)},
        {"decompose": _moving(force_n=3.0)},
        {"effects": _asks("roles", "Patient")},
        {"effects": lambda self, action, belief: belief.related(("on", "cube", "desk"))},
        {"effects": lambda self, action, belief: belief.related(("on", belief.held.thing, "x")), "decompose": GRIPS},
    ],
)  # fmt: skip
def test_what_keeps_the_contract(changes: dict[str, object], recwarn: pytest.WarningsRecorder) -> None:
    check_task_type(_variant(**changes))
    assert not recwarn.list


@pytest.mark.parametrize(
    ("where", "name", "roles"), [("parameters", "where", ()), ("roles", "Agent", (Role("Agent", effector=True),))]
)
def test_what_the_sample_has_not_is_excused_and_said(where: str, name: str, roles: tuple[Role, ...]) -> None:
    with pytest.warns(UserWarning, match=f"x:Fine: effects was not checked: it asks for '{name}'"):
        check_task_type(_variant(effects=_asks(where, name), roles=roles))


def test_relations_and_kinds_are_those_that_installed_plugins_declare() -> None:
    assert set(RELATIONS) == set(LOCATIONS) and "on" in RELATIONS
    assert {name: set(known) for name, known in KINDS.items()} == {name: set(kind.knows()) for name, kind in MOTIONS.items()}
    assert {"force_n", "to", "expect"} <= set(KINDS["gripper"])


OWN = """
from cramlite.model import *
from cramlite.plugin import *
class Levitating(TaskType):
    task, summary = "x:Levitating", "rise"
    def decompose(self, action, belief):
        yield Decomposition((Motion(action.inside("rise"), "{kind}", Location("above", "{relation}")),), "rise")
@hookimpl
def task_types(): return [Levitating()]
@hookimpl
def resolve_location(location, belief, context):
    return iter([context.robot]) if location.relation == "above" else None
@hookimpl
def resolve_motion(motion): return context.robot if motion.kind == "levitate" else None
"""


@pytest.mark.parametrize(
    ("kind", "relation", "says"),
    [("levitate", "above", ""), ("levitating", "above", "kind 'levitating'"), ("levitate", "abov", ""), ("linear", "abov", "'abov'")],
)
def test_kinds_and_relations_that_the_plugin_answers_itself(kind: str, relation: str, says: str) -> None:
    module = ModuleType("levitating")
    exec(OWN.format(kind=kind, relation=relation), vars(module))
    if not says:
        check_plugin(module)
        return
    with pytest.raises(AssertionError, match=says):
        check_plugin(module)
    check_plugin(module, kinds={**KINDS, "levitating": ()}, relations=(*RELATIONS, "abov"))


def test_files(tmp_path: Path) -> None:
    path = tmp_path / "one.py"
    path.write_text("from cramlite.plugin import hookimpl\n@hookimpl\ndef robots():\n    return []\n")
    check_file(path)
    path.write_text("from cramlite.plugin import hookimpl\n@hookimpl\ndef robts():\n    return []\n")
    with pytest.raises(AssertionError, match="robts"):
        check_file(path)


def _lines(**changes: object) -> Backend:
    body = {"name": "lines", "executable": False, "emit": lambda self, program, robot: Code("lines", "one\n", {1: "1.Reaching"}, ".txt")}
    backend: Backend = type("Lines", (), body | changes)()
    return backend


def _without(task: str) -> Callable[[object, Program, object], Code]:
    """It refuses the steps of one task, by their names."""

    def emit(self: object, program: Program, robot: object) -> Code:
        refused = [s.origin for s in program.steps if s.origin.startswith(task)]
        if refused:
            raise UserError(f"{refused[0]}: there is no such step in this language")
        return Code("lines", "one\n", {}, ".txt")

    return emit


SEEN = Expert("seen", "whether it is seen", ("view",), ("seen",), lambda inputs: {"seen": "yes"}, domains={"seen": ("yes",)})
LIGHT = Predicate("light", 1, lambda phase, thing: (), doc="It is light.")
ARM = sample_robot()
COUNT = iter(range(99))


@pytest.mark.parametrize(
    ("check", "good", "bad", "says"),
    [
        (check_expert, SEEN, replace(SEEN, outputs=()), "makes nothing"),
        (check_expert, SEEN, replace(SEEN, domains={"seem": ("yes",)}), "seem"),
        (check_expert, SEEN, replace(SEEN, inputs=("seen",)), "needs what it makes"),
        (check_expert, SEEN, replace(SEEN, cost_ms=0.0), "measured"),
        (check_predicate, LIGHT, replace(LIGHT, arity=2), "2 arguments"),
        (check_predicate, LIGHT, replace(LIGHT, name="Light"), "rules cannot write this name"),
        (check_predicate, LIGHT, replace(LIGHT, doc=""), "no sentence"),
        (check_backend, _lines(), _lines(emit=lambda *_: Code("lines", "one\n", {2: "1.Reaching"}, ".txt")), "has a line 2, but"),
        (check_backend, _lines(), _lines(emit=lambda *_: Code("lines", "one\n", {1: "9.Flying"}, ".txt")), "9.Flying"),
        (check_backend, _lines(), _lines(emit=lambda *_: Code("lines", f"{next(COUNT)}\n", {}, ".txt")), "two texts"),
        (check_backend, _lines(emit=_without("3.Placing")), _lines(emit=_without("1.Reaching")), "no program for"),
        (check_robot, ARM, replace(ARM, home=(9.0, *ARM.home[1:])), "outside"),
        (check_robot, ARM, replace(ARM, velocity=ARM.velocity[1:]), "values of 'velocity'"),
        (check_robot, ARM, replace(ARM, mjcf=lambda: ARM.mjcf().replace('"tcp"', '"tool"')), "site 'tcp'"),
    ],
)  # fmt: skip
def test_contracts_of_other_kinds(check: Callable[[object], None], good: object, bad: object, says: str) -> None:
    check(good)
    with pytest.raises(AssertionError, match=says):
        check(bad)
