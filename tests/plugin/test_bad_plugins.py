"""Plugins that cannot work are explained. A file that somebody named ends the command; an installed plugin is isolated
and named: the others load, and a program is still made."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from conftest import COMMANDS, ROOT, Run

from cramlite import Engine, data_folder
from cramlite.plugin import UserError
from cramlite.plugin.registry import Registry

Plugin = Callable[[str, str], Path]
Install = Callable[..., None]
PARKING = ROOT / "scenarios" / "tasks" / "parking_arms.yaml"
OBJECTS = "@hookimpl\ndef resolve_object(designator, belief, context):\n    return None\n"
THING = "@hookimpl\ndef {hook}():\n    return [{thing}]\n"

BAD_AT_LOAD = {
    "missing package": ("import no_such_package_xyz.part\n" + OBJECTS, "needs the package 'no_such_package_xyz'"),
    "missing part of cramlite": ("import cramlite.levitation\n" + OBJECTS, "written for another version"),
    "missing name of cramlite": ("from cramlite import Levitation\n" + OBJECTS, "written for another version"),
    "wrong argument": (
        "@hookimpl\ndef resolve_object(designator, beleif):\n    return None\n",
        "hook 'resolve_object' has no argument 'beleif'; did you mean 'belief'?",
    ),
    "argument of a hook without": ("@hookimpl\ndef task_types(engine):\n    return []\n", "it takes none"),
    "no hook": ("@hookimpl\ndef resolve_objct(d):\n    return None\n", "did you mean 'resolve_object'?"),
    "ends the process": ("import sys\nsys.exit(7)\n", "ends the process when it is imported (exit 7)"),
    "no Python": ("def f(:\n", "line 4 is no Python"),
    "nothing marked": (
        "def resolve_object(designator, belief, context):\n    return None\n",
        "marked with '@hookimpl'",
    ),
    "breaks": ("raise RuntimeError('no camera')\n", "RuntimeError: no camera"),
}


@pytest.mark.parametrize("what", BAD_AT_LOAD)
def test_what_cannot_be_loaded(what: str, plugin: Plugin, run: Run) -> None:
    body, says = BAD_AT_LOAD[what]
    ran = run("plugins", "--plugin", plugin("strange", body))
    assert ran.code == 3
    assert f"NOT LOADED: {says}" in ran.out or says in ran.out
    assert ran.out.count("NOT LOADED") == 1  # the others are
    assert "Traceback" not in ran.out + ran.err


@pytest.mark.parametrize("what", BAD_AT_LOAD)
def test_a_file_that_cannot_be_loaded_ends_the_command(what: str, plugin: Plugin, run: Run) -> None:
    body, says = BAD_AT_LOAD[what]
    file = plugin("strange", body)
    ran = run("tasks", "--plugin", file)
    assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert f"The plugin file '{file}' cannot be used: " in ran.err
    assert says in ran.err
    with pytest.raises(UserError, match="cannot be used"):
        Engine(files=[file])
    assert "soma:Grasping" in run("tasks", "--plugin", plugin("fine", OBJECTS)).out


@pytest.mark.parametrize("content", [b"\x89PNG\r\n\0\0", b"\xff\xfe\x80", b"x = 1\0", b""])
def test_a_file_that_is_no_module(content: bytes, run: Run, tmp_path: Path) -> None:
    for name in ("strange.py", "strange.png"):
        file = tmp_path / name
        file.write_bytes(content)
        ran = run("tasks", "--plugin", file)
        assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1)
        assert f"'{file}' cannot be used: " in ran.err
        assert "it has no hook" in ran.err if (content, name) == (b"", "strange.py") else "is no Python" in ran.err
        assert run("plugins", "--plugin", file).out.count("NOT LOADED") == 1


EVERY_COMMAND = {
    "check": ("fetch_from_hanger",),
    "compare": ("run", "log.csv"),
    "controller": ("--seconds", "0.1"),
    "execute": ("program.script", "--world", "fetch_from_hanger"),
    "judge": ("program.script", "--world", "fetch_from_hanger", "--goal", "coffee in basket"),
    "preflight": ("program.script", "--world", "fetch_from_hanger"),
    "goal": ("hang_up_a_product",),
    "experiment": ("fetch_from_hanger",),
    "explain": ("run",),
    "import": ("scene.xml",),
    "interpret": ("episode",),
    "new": ("task", "thing"),
    "ontology": ("check",),
    "perceive": ("fetch_from_hanger_camera",),
    "query": ("SELECT ?a WHERE { ?a ?b ?c }",),
    "learn": ("shown", "--task", "shelving"),
    "library": ("add", "cartons"),
    "calibrate": ("pictures",),
    "record": ("fetch_from_hanger", "--out", "recorded"),
    "resolve": ("fetch_from_hanger", "--out", "run"),
    "schema": ("rule",),
    "serve": (),
    "tasks": (),
    "show": ("fetch_from_hanger",),
    "view": ("run",),
    "export": ("run", "--to", "csv"),
    "mcp": (),
}


@pytest.mark.parametrize("command", [c for c in COMMANDS if c not in ("plugins", "doctor")])
def test_every_command_ends_before_any_work(
    command: str, plugin: Plugin, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "program.script").write_text("def p():\n  sleep(0.1)\nend\n")
    file = plugin("strange", "raise RuntimeError('no camera')\n")
    before = set(tmp_path.iterdir())
    monkeypatch.chdir(tmp_path)
    ran = run(command, *EVERY_COMMAND[command], "--plugin", file)
    assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert f"'{file}' cannot be used: RuntimeError: no camera (strange.py:4)" in ran.err
    assert {p for p in tmp_path.iterdir() if p.name != "__pycache__"} == before


TASK_WITH_ALIAS = (
    "class T(TaskType):\n    task = 'x:T'\n    aliases = {}\n    def decompose(self, a, b): return []\n"
    + THING.format(hook="task_types", thing="T()")
)
BAD_DECLARATIONS = {
    "a class": (
        "class T(TaskType):\n    task = 'x:T'\n    def decompose(self, a, b): return []\n" + THING.format(hook="task_types", thing="T"),
        "task_types gave the class T; declare an instance, T()",
    ),
    "something else": (THING.format(hook="robots", thing="'ur5e'"), "robots gave 'ur5e', which has no 'type'"),
    "no path": (THING.format(hook="ontologies", thing="None"), "ontologies gave None, which is no path"),
    "no file": (THING.format(hook="ontologies", thing="'mine.ttl'"), "ontologies gave 'mine.ttl', and there is no such file"),
    "nothing to iterate": ("@hookimpl\ndef experts():\n    return 5\n", "experts gave 5; it must give a list"),
    "a name that is taken": (
        "class E:\n    name = 'urscript'\n    executable = False\n    def emit(self, p, r): ...\n"
        + THING.format(hook="backends", thing="E()"),
        "declares 'urscript' too",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD_DECLARATIONS)
def test_what_is_declared_wrongly(what: str, plugin: Plugin, run: Run) -> None:
    body, says = BAD_DECLARATIONS[what]
    ran = run("plugins", "--plugin", plugin("strange", body), "--json")
    assert ran.code == 3
    faults = {p["name"]: p["faults"] for p in json.loads(ran.out) if p["faults"]}
    assert len(faults) == 1
    assert says in next(iter(faults.values()))[0]
    assert run("plugins").code == 0
    if what != "a name that is taken":
        named = run("tasks", "--plugin", plugin("strange", body))
        assert (named.code, named.out) == (2, "")
        assert "cannot be used: hook " in named.err and says in named.err


def test_a_bad_installed_plugin_does_not_keep_others_from_a_program(install: Install, run: Run, tmp_path: Path) -> None:
    bodies = [body for body, _ in (*BAD_AT_LOAD.values(), BAD_DECLARATIONS["something else"])]
    for k, body in enumerate(bodies):
        install(f"pack-{k}", f"bad_{k}", body=body)
    ran = run("resolve", PARKING, "--no-report", "--out", tmp_path / "run")
    assert ran.code == 0, ran.err
    for k in range(len(bodies)):
        assert f"warning: plugin 'bad_{k}' 2.5" in ran.err


def test_an_installed_plugin_with_a_broken_rule_file_is_left_out_and_named(install: Install, run: Run, tmp_path: Path) -> None:
    rules = tmp_path / "hitting.yaml"
    rules.write_text("task: soma:Hitting\nroles: {}\nsource: a test\npre: ['suports(_, _)']\nexplain: seen\n")
    task = "class T(TaskType):\n    task, rule_file = 'soma:Hitting', Path({!r})\n    def decompose(self, a, b): return []\n"
    install("pack", "hitting", body=f"from pathlib import Path\n{task.format(str(rules))}" + THING.format(hook="task_types", thing="T()"))
    read = run("interpret", data_folder("scenarios") / "fetch_from_hanger" / "demonstration")
    assert read.code == 0 and "plugin 'hitting' 2.5, hook task_types, at soma:Hitting: " in read.err
    assert f"{rules}:4: in 'suports(_, _)'" in read.err
    listed = run("plugins")
    assert listed.code == 3 and f"{rules}:4" in listed.out


# Two of one name


def test_two_files_of_one_name(plugin: Plugin, tmp_path: Path) -> None:
    first = plugin("twin", OBJECTS)
    (tmp_path / "other").mkdir()
    second = tmp_path / "other" / "twin.py"
    second.write_text(first.read_text())
    registry = Registry((first, second), strict=False)
    (fault,) = registry.faults
    assert "two plugins are called 'twin'" in fault.error
    assert str(first) in fault.error
    assert [i.hooks for i in registry.infos if i.name == "twin"] == [("resolve_object",), ()]
    with pytest.raises(UserError, match=f"'{second}' cannot be used: two plugins are called 'twin'"):
        Registry((first, second))


@pytest.mark.parametrize("name", ["holding", "physics"])
def test_a_file_with_the_name_of_a_shipped_plugin_is_refused(name: str, plugin: Plugin, run: Run) -> None:
    file = plugin(name, OBJECTS)
    ran = run("tasks", "--plugin", file)
    assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert f"'{file}' cannot be used: there is a plugin '{name}' already, of cramlite 0.1.0" in ran.err
    assert f"rename the file, and if it is to replace that one, add --block {name}" in ran.err
    for blocked in ((), (name,)):  # to block the name would leave out both
        with pytest.raises(UserError, match="rename the file"):
            Engine(files=[file], blocked=blocked)
    listed = Registry((file,), strict=False)
    assert [bool(i.hooks) for i in listed.infos if i.name == name] == [False, True], "the shipped one is in use"
    other = file.rename(file.with_stem("my_own"))
    instead = Registry((other,), blocked=(name,))
    assert instead.faults == []
    assert {i.name for i in instead.infos} & {name, "my_own"} == {"my_own"}


VALIDATOR = (
    "from cramlite.plugin import Finding\n"
    "class Checker:\n    name, cost = {name}, {cost}\n"
    "    def check(self, candidate):\n        {body}\n"
    "@hookimpl\ndef validators():\n    return [Checker()]\n"
)
FIELDS = {"name": "'b'", "cost": "'facts'", "body": "yield Finding('b', True, 'fine')"}


def declared(hook: str, call: str) -> str:
    return f"def f(*a):\n    return []\n@hookimpl\ndef {hook}():\n    return [{call}]\n"


UNREADABLE = {
    "cost": (VALIDATOR.format(**FIELDS | {"cost": "'rolout'"}), "'b', whose 'cost' is 'rolout'; did you mean 'rollout'?"),
    "several costs": (VALIDATOR.format(**FIELDS | {"cost": "('ik', 'path')"}), "whose 'cost' is ('ik', 'path'); it must be one word"),
    "no cost": (VALIDATOR.format(**FIELDS).replace("name, cost =", "name, cots ="), "which has no 'cost'"),
    "no name": (VALIDATOR.format(**FIELDS | {"name": "None"}), "whose 'name' is None; it must be text"),
    "check": (VALIDATOR.format(**FIELDS).replace("@hook", "Checker.check = 5\n@hook"), "whose 'check' is 5; it must be a function"),
    "scope": (
        declared("experts", "Expert('e', 'e', (), ('x',), f, scope='objects')"),
        "'e', whose 'scope' is 'objects'; did you mean 'object'?",
    ),
    "outputs": (declared("experts", "Expert('e', 'e', (), 'x', f)"), "whose 'outputs' is 'x'; it must be a tuple"),
    "cost of an expert": (declared("experts", "Expert('e', 'e', (), ('x',), f, cost_ms='3')"), "it must be a number"),
    "phase": (
        declared("predicates", "Predicate('p', 0, f, frozenset({'before'}))"),
        "'p', whose 'phases' is 'before'; valid are: post, pre, run",
    ),
    "phases": (declared("predicates", "Predicate('p', 0, f, 'run')"), "whose 'phases' is 'run'; it must be a tuple"),
    "static": (declared("predicates", "Predicate('p', 0, f, static=True)"), "'p', whose 'static' is True; it must be a function"),
    "fluent": (declared("predicates", "Predicate('p', 0, f, fluent=0.5)"), "'p', whose 'fluent' is 0.5; it must be a Fluent"),
    "implies": (
        "from cramlite.plugin import Fluent\n" + declared("predicates", "Predicate('p', 0, f, fluent=Fluent(implies='touches'))"),
        "'p', whose fluent's 'implies' is 'touches'; it must be a tuple",
    ),
    "executable": (
        "class E:\n    name, executable = 'e', 'no'\n    def emit(self, p, r): ...\n" + declared("backends", "E()"),
        "'e', whose 'executable' is 'no'; it must be True or False",
    ),
    "no executable": (
        "class E:\n    name = 'e'\n    def emit(self, p, r): ...\n" + declared("backends", "E()"),
        "which has no 'executable'",
    ),
    "files": (declared("object_models", "ModelMaker('m', f, files='mesh')"), "whose 'files' is 'mesh'; it must be a tuple"),
    "a task of no TaskType": (
        "class T:\n    task = 'x:T'\n    def decompose(self, a, b): return []\n" + declared("task_types", "T()"),
        "use the class TaskType",
    ),
    "an exporter of its own class": (
        "class E:\n    name, suffix, about = 'e', '.e', 'x'\n    def write(self, r, p): ...\n" + declared("exporters", "E()"),
        "which has no 'needs'; use the class Exporter",
    ),
    "a model of its own class": (
        "class M:\n    name = 'm'\n    def make(self, **p): ...\n" + declared("object_models", "M()"),
        "which has no 'hung'; use the class ModelMaker",
    ),
    "order": (declared("report_sections", "ReportSection('s', 'last', f)"), "whose 'order' is 'last'; it must be a number"),
    "aliases": (TASK_WITH_ALIAS.format("'Ab'"), "'x:T', whose 'aliases' is 'Ab'; it must be a tuple"),
}


@pytest.mark.parametrize("what", UNREADABLE)
def test_what_would_switch_a_thing_off_unsaid_is_refused(what: str, plugin: Plugin, run: Run) -> None:
    body, says = UNREADABLE[what]
    file = plugin("odd", "from cramlite.plugin import Predicate\nfrom cramlite.plugin.expert import Expert\n" + body)
    ran = run("tasks", "--plugin", file)
    assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1), ran.err
    assert f"'{file}' cannot be used: hook " in ran.err and says in ran.err
    listed = run("plugins", "--plugin", file)
    assert listed.code == 3 and says in listed.out
    assert "plugin_faults.py" not in ran.err + listed.out, "it is the plugin's defect, not the engine's"


def test_what_is_declared_rightly_is_not_refused(plugin: Plugin) -> None:
    bodies = (
        *(VALIDATOR.format(**FIELDS | {"cost": f"'{cost}'"}) for cost in ("facts", "ik", "path", "rollout")),
        "from cramlite.plugin import Expert\n" + declared("experts", "Expert('e', 'e', (), ('x',), f, scope='object')"),
        "from cramlite.plugin import Predicate\n" + declared("predicates", "Predicate('p', 0, f, frozenset({'run'}))"),
        declared("object_models", "ModelMaker('m', f, files=('mesh',))"),
        declared("report_sections", "ReportSection('s', 2.5, f)"),
        TASK_WITH_ALIAS.format("('Ab',)"),
        "class R:\n    name, order = 'r', 1\n    def repair(self, episode): return episode\n" + declared("episode_repairs", "R()"),
    )
    for k, body in enumerate(bodies):
        assert Registry((plugin(f"fine_{k}", body),)).faults == []


BROKEN_BY = """\
scenario: t
tasks: [ParkingArms]
robot: {{type: {robot}}}
things: [{{name: t, model: {model}, at: {{position: [0.5, 0, 0.1]}}}}]
"""


@pytest.mark.parametrize(
    ("robot", "model", "body", "code", "says"),
    [
        (
            "ur5e", "m", declared("object_models", "ModelMaker('m', lambda **p: 5)"),
            3, "yaml:4: the object model 'm' makes 5; it should make a",
        ),
        (
            "mine", "block",
            "from cramlite.model import replace\nfrom cramlite_plugins.robots import arms\n"
            + declared("robots", "replace(next(iter(arms.robots())), type='mine', mjcf=f)"),
            2, "the MJCF of robot 'mine' cannot be used: it is []",
        ),
    ],
    ids=["model", "robot"],
)  # fmt: skip
def test_what_makes_nonsense_is_named(
    robot: str, model: str, body: str, code: int, says: str, plugin: Plugin, run: Run, tmp_path: Path
) -> None:
    (tmp_path / "broken.yaml").write_text(BROKEN_BY.format(robot=robot, model=model))
    ran = run("check", tmp_path / "broken.yaml", "--plugin", plugin("odd", body))
    assert (ran.code, ran.err.count("\n")) == (code, 1) and says in ran.err, ran.err


NO_FINDINGS = {
    "text": ("yield 'bad'", "check gives Findings, not 'bad'; write Finding(name, passed, reason)"),
    "True": ("return True", "check gives Findings, in a list or one after another with 'yield', not True"),
    "nothing": ("pass", "check gives Findings, in a list or one after another with 'yield', not None"),
    "passed": ("yield Finding('b', 'no', 'too fast')", "'passed' of a Finding is True or False, not 'no'"),
    "raises": ("1 / 0", "ZeroDivisionError: division by zero (broken.py:"),
    "raises late": ("yield Finding('b', True, 'fine')\n        1 / 0", "ZeroDivisionError: division by zero (broken.py:"),
}


@pytest.mark.heavy
@pytest.mark.parametrize("what", NO_FINDINGS)
def test_a_validator_that_answers_nonsense_is_named(what: str, plugin: Plugin, run: Run, tmp_path: Path) -> None:
    body, says = NO_FINDINGS[what]
    file = plugin("broken", VALIDATOR.format(**FIELDS | {"body": body}))
    ran = run("resolve", PARKING, "--plugin", file, "--no-report", "--out", tmp_path / "run")
    assert (ran.code, ran.out) == (3, "")
    assert f"Fault: plugin 'broken', hook validators, at b: {says}" in ran.err
    assert "defect" not in ran.err and "proof.py" not in ran.err


def test_an_installed_validator_is_named_with_its_version(install: Install, run: Run, tmp_path: Path) -> None:
    install("pack-validator", "calm", body=VALIDATOR.format(**FIELDS | {"body": "return True"}))
    ran = run("resolve", PARKING, "--no-report", "--out", tmp_path / "run")
    assert ran.code == 3
    assert "Fault: plugin 'calm' 2.5, hook validators, at b: check gives Findings" in ran.err
    assert run("plugins", "--block", "calm").code == 0


def test_a_backend_that_breaks_is_named_by_its_plugin(plugin: Plugin, run: Run, tmp_path: Path) -> None:
    broken = "class E:\n    name, executable = 'e', True\n    def emit(self, p, r):\n        1 / 0\n"
    file = plugin("writer", broken + declared("backends", "E()"))
    ran = run("resolve", PARKING, "--plugin", file, "--backend", "e", "--no-report", "--out", tmp_path / "run")
    assert ran.code == 3
    assert "Fault: plugin 'writer', hook backends, at " in ran.err and "(writer.py:" in ran.err


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """A distribution as an installer would leave it: module, metadata and entry point, on the path."""
    written: list[str] = []
    monkeypatch.syspath_prepend(str(tmp_path))

    def write(distribution: str, name: str, requires: str = "", version: str = "2.5", body: str = OBJECTS) -> None:
        module = f"{distribution.replace('-', '_')}_{name}"
        written.append(module)
        (tmp_path / f"{module}.py").write_text(f"from cramlite.model import *\nfrom cramlite.plugin import *\n{body}")
        info = tmp_path / f"{distribution.replace('-', '_')}-{version}.dist-info"
        info.mkdir()
        asks = f"Requires-Dist: {requires}\n" if requires else ""
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: {version}\n{asks}")
        (info / "entry_points.txt").write_text(f"[cramlite]\n{name} = {module}\n")

    yield write
    for module in written:
        sys.modules.pop(module, None)


def test_two_packages_of_one_name(install: Install, run: Run) -> None:
    install("pack-a", "shared")
    install("pack-b", "shared")
    ran = run("plugins")
    assert ran.code == 3
    assert "two plugins are called 'shared'" in ran.out
    assert "pack-a" in ran.out and "pack-b" in ran.out
    assert run("plugins", "--block", "shared").code == 0


@pytest.mark.parametrize(
    ("requires", "fine"),
    [
        ("cramlite<0.1", False),
        ("cramlite (>=7)", False),
        ("cramlite~=0.0.3", False),
        ("cramlite==", False),
        ("cramlite>=0.1,<0.2", True),
        ("cramlite-extras<0.1", True),
        ("", True),
    ],
)
def test_plugins_for_other_versions_are_not_loaded(requires: str, fine: bool, install: Install) -> None:
    install("pack-old", "old", requires)
    registry = Registry()
    (info,) = [i for i in registry.infos if i.name == "old"]
    assert (info.distribution, info.version) == ("pack-old", "2.5")
    assert bool(info.hooks) == fine
    assert ("this is 0.1.0; update it with 'pip install --upgrade pack-old'" in info.fault) == (
        not fine and "==" not in requires
    )
    assert len(registry.faults) == (not fine)


# Blocking and preferring


# What is wrong with a task type comes out while it is resolved

TASK = (
    "class Odd(TaskType):\n    task = 'cram:Odd'\n    summary = 'odd'\n"
    "    def decompose(self, action, belief):\n        {body}\n@hookimpl\ndef task_types():\n    return [Odd()]\n"
)


@pytest.mark.parametrize(
    ("body", "says"),
    [
        (
            "yield Decomposition((5,), 'odd')",
            "a step of a Decomposition is an Action, Object, Location or Motion, not 5",
        ),
        ("return Decomposition((), 'odd')", "decompose returned a Decomposition; it has to yield it"),
        ("yield 5", "decompose yields Decompositions, not int"),
    ],
)
def test_a_wrong_decomposition_is_the_plugins_bug(
    body: str, says: str, plugin: Plugin, run: Run, tmp_path: Path
) -> None:
    scenario = tmp_path / "odd.yaml"
    scenario.write_text("scenario: odd\ndesignator: Odd\nrobot: {type: ur5e}\nthings: []\n")
    file = plugin("odd", TASK.format(body=body))
    ran = run("resolve", scenario, "--plugin", file, "--no-report", "--out", tmp_path / "run")
    assert ran.code == 3
    fault = ran.err.split("\n  ")[1]
    assert fault.startswith("Fault: plugin 'odd'") and says in fault and "at 1.Odd" in fault


def test_a_file_that_was_not_loaded_is_named_and_not_what_follows_from_it(
    plugin: Plugin, run: Run, spoiled: Callable[..., Path]
) -> None:
    file = plugin("odd", TASK.format(body="yield").replace("def task_types", "def task_type"))
    ran = run("resolve", spoiled(("- ParkingArms", "- Odd")), "--plugin", file)
    assert ran.code == 2
    (said,) = ran.err.strip().split("\n")
    assert f"'{file}' cannot be used: there is no hook 'task_type'; did you mean 'task_types'?" in said
