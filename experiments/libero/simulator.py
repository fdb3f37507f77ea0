"""LIBERO's simulator and checks as a process: it runs in an environment of its own and speaks JSON lines.

Nothing of cramlite is imported here; ``connection.py`` starts it. Requests: ``reset`` (suite, task, state), ``scene``, ``look``,
``cameras``, ``check``, and those of a robot process (``hello``, ``step``, ``end``; docs/how-to/drive_a_robot.md): its Panda takes deltas
of its end effector through robosuite's operational space controller, as in the published protocol. A request that cannot be served is
answered with ``error``.
"""

from __future__ import annotations

import base64
import difflib
import io
import os
import sys
from pathlib import Path
from typing import Any

os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parent))
from benchmark_lines import Refused, serve
from changes import PREFIX, Change, cases
from instability import instability
from levels import with_levels
from looking import Eye
from masses import with_masses
from obstacles import PREFIX as SAFE
from obstacles import Obstacles, problem
from wrist_force import WristForce

RATE, IDLE = 20, 10
"""Rate of actions [Hz], and number of idle actions after a reset, as in LIBERO's evaluation."""
OPEN = 0.08
"""Opening of the open hand [m]."""
QUANTUM = 0.25
"""Change of the hand's command by one action, -1 (open) to 1 (closed): 25 physics steps of 0.01 each (PandaGripper)."""
SHUT = 0.0019
"""Opening below which fingers that have hardly moved for half a second have closed on nothing [m]: they creep from 2.1 to 1 mm in 1 s."""
CREEP = 0.002
"""Largest remaining distance of the fingers to a commanded opening, once they have hardly moved for half a second [m]: at most 1.5 mm
were seen."""
DRAWS = 10
"""Number of attempts to draw places for the things; one attempt must find room for all of them."""
PIXELS = 256
HAND = "gripper0_right_gripper"


class Simulator:
    """LIBERO's simulator, with one episode at a time, and its checks."""

    def __init__(self) -> None:
        self.env: Any = None
        self.steps, self.first = 0, None
        self.hand = 0.0
        self.force: Any = None
        self.change: Any = None
        self.obstacles: Any = None
        self.tracked, self.eye = True, None

    def reset(self, suite: str, task: int, state: int, tracked: bool = True) -> dict[str, Any]:
        """Begin an episode, after LIBERO's idle actions; if not ``tracked``, no pose is told while the robot moves, and another task
        as a sentence."""
        self.tracked = tracked
        from libero.libero import benchmark, get_libero_path

        known, self.change, self.obstacles = benchmark.get_benchmark_dict(), None, None
        if suite.startswith(PREFIX):
            found = cases(suite)
            if not (0 <= task < len(found) and state in (0, 1)):
                raise Refused(f"'{suite}' has cases 0 to {len(found) - 1}, each as a control (state 0) and changed (1)")
            self.change = Change(found[task], state == 1)
            suite, task, state = found[task]["task_suite_name"], found[task]["task_index"], found[task]["init_state_index"]
        if suite.startswith(SAFE):
            path, start = problem(suite, task, state)
            self.begin(str(path), start, state)
            self.obstacles = Obstacles(self.env.env)
            return {"task": path.stem, "language": self.env.language_instruction}
        if suite not in known:
            near = difflib.get_close_matches(suite, known, n=5, cutoff=0.3)
            raise Refused(f"there is no suite '{suite}'; did you mean one of {', '.join(near or sorted(known)[:5])}?")
        tasks = known[suite]()
        if not 0 <= task < tasks.get_num_tasks():
            raise Refused(f"suite '{suite}' has tasks 0 to {tasks.get_num_tasks() - 1}, not {task}")
        found, states = tasks.get_task(task), tasks.get_task_init_states(task)
        if not 0 <= state < len(states):
            raise Refused(f"task {task} of '{suite}' has initial states 0 to {len(states) - 1}, not {state}")
        path = os.path.join(get_libero_path("bddl_files"), found.problem_folder, found.bddl_file)
        self.begin(path, states[state], state)
        return {"task": found.name, "language": self.env.language_instruction}

    def begin(self, path: str, start: Any, seed: int) -> None:
        """Begin an episode of a problem file from an initial state."""
        self.eye = None
        if self.env is not None:
            self.env.close()
            self.env = None
        self.env = drawn(path, seed)
        self.env.set_init_state(start)
        robot = self.env.robots[0]
        self.force = WristForce(self.env.env, lambda: robot.ee_force)
        self.hand = 0.0
        if self.change is not None:
            self.change.set_up(self.env.env)
        for _ in range(IDLE):
            self.env.step(np.zeros(7))
        if not self.tracked:
            self.eye = Eye(self.env.sim.model._model, self.env.sim.data._data, "robot0_link0")
        self.steps, self.first = 0, None

    def scene(self, model: bool = True) -> dict[str, Any]:
        """Describe the world: the model as MJCF with its state, or the poses of bodies alone; the goal and its sentence, the regions,
        and the position of the camera."""
        env, sim = self.env.env, self.env.sim
        on = [literal[2] for literal in env.parsed_problem["goal_state"] if literal[0] == "on"]
        text = with_levels(with_masses(sim.model.get_xml(), sim.model._model), on) if model else ""
        whole = {"xml": text, "qpos": sim.data.qpos.tolist()} if model else {}
        base = sim.model.body_name2id("robot0_link0")
        things = {n: env.get_object(n) for n in (*env.objects_dict, *env.fixtures_dict)}
        return {
            **(whole or {"poses": poses(sim)}), "goal": env.parsed_problem["goal_state"],
            "bodies": {n: thing.root_body for n, thing in things.items() if hasattr(thing, "root_body")},
            "regions": {n: {"bodies": above(sim, n), "box": site_box(sim, n)} for n in env.object_sites_dict},
            "absent": sorted(things[n].root_body for n in self.away),
            "keep": sorted(things[n].root_body for n in self.obstacles.here) if self.obstacles else [],
            "language": self.env.language_instruction, "agentview": sim.data.get_camera_xpos("agentview").tolist(),
            "base": [*sim.data.body_xpos[base].tolist(), *sim.data.body_xquat[base].tolist()],
        }  # fmt: skip

    def hello(self, **_: Any) -> dict[str, Any]:
        """Return the description of the robot."""
        controller = self.env.robots[0].controller
        inertia = 1.0 / float(controller.kp[0])  # of a critically damped spring, which is pulled along and holds an action for a period
        lag = 2.0 * inertia**0.5 - 0.5 / RATE
        return {
            "protocol": 1, "robot": "libero_panda", "actions": "deltas", "rate": RATE, "lag": lag, "inertia": inertia,
            "most": [float(controller.output_max[0]), float(controller.output_max[3])], "tolerance": [0.004, 0.02],
            "fingers": OPEN * QUANTUM / 4 + CREEP, "closed": SHUT, "hesitation": 2 / QUANTUM / RATE + 0.05,
            "settling": 1.0 / RATE,
        } | self.feel()  # fmt: skip

    def step(self, delta: list[float], opening: float, grip: float) -> dict[str, Any]:
        """Execute an action: a delta of the effector and an opening; ``grip`` is ignored, as LIBERO has a grip force of its own."""
        del grip
        controller = self.env.robots[0].controller
        action = np.clip(np.array(delta) / controller.output_max, -1.0, 1.0)
        wanted = 1.0 - opening / (OPEN / 2)
        turn = 0.0 if abs(wanted - self.hand) <= QUANTUM / 2 else float(np.sign(wanted - self.hand))
        self.hand = float(np.clip(self.hand + QUANTUM * turn, -1.0, 1.0))
        self.force.begin()
        self.env.step(np.array([*action, turn]))
        self.steps += 1
        if self.first is None and self.success():
            self.first = self.steps
        if self.change is not None:
            self.change.see(self.env.env, self.steps)
        if self.obstacles is not None:
            self.obstacles.see(self.env.env)
        return self.feel() | {"stop": instability(self.env.sim.data._data)}

    def feel(self) -> dict[str, Any]:
        """Return the robot's joint positions, finger opening and wrist force; where the scene can change, also its poses and goal."""
        sim, robot = self.env.sim, self.env.robots[0]
        fingers = [float(sim.data.get_joint_qpos(j)) for j in robot.gripper.joints]
        body = sim.model.body_name2id(HAND)
        turn = sim.data.get_site_xmat("gripper0_ft_frame")
        weight = np.array([0.0, 0.0, -9.81 * float(sim.model.body_subtreemass[body])])
        force = -(turn @ self.force.mean() + weight)
        return {
            "joints": np.array(robot._joint_positions).tolist(), "opening": abs(fingers[0]) + abs(fingers[1]),
            "wrench": [*force.tolist(), 0.0, 0.0, 0.0], **self.read(),
        }  # fmt: skip

    def read(self) -> dict[str, Any]:
        """Return the poses of movable bodies, and the goal if it was replaced, or only the sentence that is asked for since; {} in suites
        whose scenes never change during a run."""
        if self.change is None:
            return {}
        if not self.tracked:
            return {"sentence": self.change.sentence}
        env, data = self.env.env, self.env.sim.data
        there = {n: int(env.obj_body_id[n]) for n in env.objects_dict if n not in self.change.away}
        at = {n: [*data.body_xpos[b].tolist(), *data.body_xquat[b].tolist()] for n, b in there.items()}
        poses = {env.get_object(n).root_body: pose for n, pose in at.items()}
        return {"poses": poses, "goal": self.change.goal}

    @property
    def away(self) -> set[str]:
        """Things that are not in the scene, though they are in the model."""
        return self.change.away if self.change else self.obstacles.away if self.obstacles else set()

    def success(self) -> bool:
        """Return the result of LIBERO's check; or, if the task was cancelled, whether the hand has stopped."""
        cancelled = self.change is not None and self.change.goal == []
        return bool(self.change.stopped) if cancelled else bool(self.env.check_success())

    def check(self) -> dict[str, Any]:
        """Return the result of LIBERO's check: now, and at which step it was true for the first time."""
        changed = self.change.applied if self.change else None
        avoided = self.obstacles.avoided if self.obstacles else None
        return {"success": self.success(), "first": self.first, "steps": self.steps, "changed": changed, "avoided": avoided}

    def look(self, colour: bool = True) -> dict[str, Any]:
        """Return a picture with depth by the fixed camera, calibrated to the robot's base, and the robot's joints."""
        if self.eye is None:
            self.eye = Eye(self.env.sim.model._model, self.env.sim.data._data, "robot0_link0")
        joints = self.feel()
        return self.eye.taken(colour) | {n: joints[n] for n in ("joints", "opening")}

    def cameras(self) -> dict[str, Any]:
        """Take a picture with each camera of the published protocol, as PNG in base64."""
        from PIL import Image

        model, data = self.env.sim.model._model, self.env.sim.data._data
        found = {}
        seen = mujoco.MjvOption()
        seen.geomgroup[0] = 0  # what bodies collide with; robosuite draws group 1
        renderer = mujoco.Renderer(model, PIXELS, PIXELS)
        for name in ("agentview", "robot0_eye_in_hand"):
            renderer.update_scene(data, name, seen)
            Image.fromarray(renderer.render()).save(buffer := io.BytesIO(), "png")
            found[name] = {
                "png": base64.b64encode(buffer.getvalue()).decode(), "fovy": float(model.camera(name).fovy[0]),
                "position": data.camera(name).xpos.tolist(), "rotation": data.camera(name).xmat.tolist(),
            }  # fmt: skip
        return found


def drawn(path: str, seed: int) -> Any:
    """Return LIBERO's environment of a problem file after a reset.

    States do not say where fixtures stand: each reset draws that anew, within 2 cm; and it draws places of all things, which a state
    replaces. A draw without room for all of them is repeated.

    Raises:
        Refused: none of ``DRAWS`` draws had.
    """
    from libero.libero.envs.env_wrapper import ControlEnv
    from robosuite.utils.errors import RandomizationError

    for again in range(DRAWS):
        np.random.seed([seed, again] if again else seed)
        try:
            env = ControlEnv(
                bddl_file_name=path, has_offscreen_renderer=False, use_camera_obs=False, horizon=100_000, ignore_done=True,
                control_freq=RATE,
            )  # fmt: skip
            env.reset()
        except RandomizationError:
            continue
        return env
    raise Refused(f"in {DRAWS} draws there was no place for all things of '{Path(path).name}'")


def poses(sim: Any) -> dict[str, list[float]]:
    """Poses of all bodies in the world: position [m], quaternion (w, x, y, z)."""
    return {n: [*sim.data.get_body_xpos(n).tolist(), *sim.data.get_body_xquat(n).tolist()] for n in sim.model.body_names}


def above(sim: Any, name: str) -> list[str]:
    """Names of the bodies that a region's site belongs to, from the nearest up to the world's."""
    body, found = int(sim.model.site_bodyid[sim.model.site_name2id(name)]), []
    while body:
        found.append(sim.model.body_id2name(body))
        body = int(sim.model.body_parentid[body])
    return found


def site_box(sim: Any, name: str) -> dict[str, Any]:
    """Pose and half sides of a region's site [m]."""
    site = sim.model.site_name2id(name)
    return {
        "position": sim.data.site_xpos[site].tolist(), "rotation": sim.data.site_xmat[site].tolist(),
        "half": sim.model.site_size[site].tolist(),
    }  # fmt: skip


if __name__ == "__main__":
    serve(Simulator())
