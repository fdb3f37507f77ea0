"""Changes of LIBERO-MAX in the middle of a run, as manifests in a folder of the user's describe them.

Only LIBERO's process reads them. A case is a pair: the same task and initial state without the change (state 0 of its suite here) and
with it (state 1). What is kept for the end is in suites whose name ends with "_end": of physical changes the third whose name has a BLAKE2b
digest of 4 bytes that 3 divides, of changed instructions the odd rows of the manifest. Suites with "seen" in their name, for runs by
camera, have changes of light and of the camera, too; they are of initial state 0, those for the end of initial state 1.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from benchmark_lines import Refused

FOLDER = "CRAMLITE_LIBERO_MAX"
"""Environment variable: the folder with core_dev.json and intent_dev.json."""
PREFIX = "libero_max_"
PHYSICAL = ("move_object", "insert_obstacle", "insert_distractors")
SEEN = (*PHYSICAL, "set_lighting", "shift_camera")
INTENT = ("replace_instruction", "cancel_instruction")
WATCHED, NET, ALONG, STILL = 10, 0.02, 0.04, 0.01
"""Limits for a hand that stopped after a cancellation: number of actions watched, net displacement, path length, and displacement of the
target [m]."""
STATE = {"core_dev.json": 1, "intent_dev.json": 0}
"""Initial state whose cases are used."""


def kept(case_id: str, row: int, intent: bool) -> bool:
    """Return whether a case of LIBERO-MAX belongs to the suites that are reserved for the final evaluation."""
    if intent:
        return row % 2 == 1
    return int.from_bytes(hashlib.blake2b(case_id.encode(), digest_size=4).digest(), "big") % 3 == 0


def cases(suite: str) -> list[dict[str, Any]]:
    """Return the cases of a suite of LIBERO-MAX, such as "libero_max_object", "libero_max_intent_goal_end",
    "libero_max_seen_10", in the manifest's order."""
    name = suite.removeprefix(PREFIX)
    end, name = name.endswith("_end"), name.removesuffix("_end")
    intent, seen = name.startswith("intent_"), name.startswith("seen_")
    name = name.removeprefix("intent_").removeprefix("seen_")
    file, operations = ("intent_dev.json", INTENT) if intent else ("core_dev.json", SEEN if seen else PHYSICAL)
    state = int(end) if seen else STATE[file]
    folder = os.environ.get(FOLDER, "")
    if not (Path(folder) / file).is_file():
        raise Refused(f"the cases of '{suite}' are in LIBERO-MAX's '{file}'; say its folder by the environment variable {FOLDER}")
    found = json.loads((Path(folder) / file).read_text())["cases"]
    return [
        c for row, c in enumerate(found)
        if c["init_state_index"] == state and c["task_suite_name"] == f"libero_{name}"
        and c["scenario"]["change"]["operation"] in operations and (seen or kept(c["case_id"], row, intent) == end)
    ]  # fmt: skip


class Change:
    """Change of one case of LIBERO-MAX, which happens when its trigger holds; in a control run it never
    happens.

    Args:
        case: of the manifest.
        comes: whether it does.
    """

    def __init__(self, case: dict[str, Any], comes: bool) -> None:
        self.scenario, self.comes = case["scenario"], comes
        self.applied: int | None = None
        self.heights: dict[str, float] = {}
        self.goal: list[list[str]] | None = None
        self.sentence = ""
        self.away: set[str] = set()
        self.moved = 0.0
        self.way: list[list[float]] = []
        self.rested: Any = None

    def set_up(self, env: Any) -> None:
        """Remove the things that are absent when a case of LIBERO-MAX begins, in runs with and without the case's change."""
        for one in self.scenario.get("setup", ()):
            name = one["object"]
            self.heights[name] = float(origin(env, name)[2])
            self.away.add(name)
            put(env, name, one["offworld_position_m"])
            solid(env, name, False)
        env.sim.forward()

    def see(self, env: Any, steps: int) -> None:
        """Apply the case's change of scene or instruction once its trigger holds; called between two actions."""
        trigger = self.scenario["trigger"]
        hand = np.array(env.sim.data.site_xpos[env.robots[0].eef_site_id])
        if self.way and len(self.way) <= WATCHED:
            self.way.append(hand.tolist())
            self.moved = float(np.linalg.norm(origin(env, trigger["value"]) - self.rested))
        if not self.comes or self.applied is not None:
            return
        if float(np.linalg.norm(hand - origin(env, trigger["value"]))) > trigger["distance_m"]:
            return
        self.applied = steps
        change = self.scenario["change"]
        getattr(self, change["operation"])(env, change, hand)
        env.sim.forward()

    @property
    def stopped(self) -> bool | None:
        """Whether the hand stopped after the task was cancelled; None without a cancellation, or if the
        benchmark took fewer than ``WATCHED`` steps since."""
        if self.goal != [] or len(self.way) <= WATCHED:
            return None
        way = np.array(self.way)
        net, along = float(np.linalg.norm(way[-1] - way[0])), float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
        return net <= NET and along <= ALONG and self.moved <= STILL

    def move_object(self, env: Any, change: dict[str, Any], hand: Any) -> None:
        """Displace a thing: by its free joint, else by moving its body in the model."""
        put(env, change["object"], origin(env, change["object"]) + np.array(change["delta_position_m"]))

    def insert_obstacle(self, env: Any, change: dict[str, Any], hand: Any) -> None:
        """Add an obstacle to the scene, between the hand and the target, at the obstacle's initial height."""
        name, target = change["object"], origin(env, change["path_target"])
        way = target - hand
        across = np.array([-way[1], way[0], 0.0]) / max(float(np.hypot(way[0], way[1])), 1e-9)
        self.insert(env, name, hand + change["path_fraction"] * way + change["lateral_offset_m"] * across)

    def insert_distractors(self, env: Any, change: dict[str, Any], hand: Any) -> None:
        """Bring absent things in beside the target, at their initial heights."""
        for one in change["placements"]:
            self.insert(env, one["object"], origin(env, one["relative_to"]) + np.array(one["offset_m"]))

    def insert(self, env: Any, name: str, place: Any) -> None:
        """Bring an absent thing into the scene at a horizontal position, at its initial height."""
        solid(env, name, True)
        put(env, name, [place[0], place[1], self.heights[name]])
        self.away.discard(name)

    def set_lighting(self, env: Any, change: dict[str, Any], hand: Any) -> None:
        """Scale all lights."""
        model = env.sim.model._model
        for light in (model.light_ambient, model.light_diffuse, model.light_specular):
            light *= change["scale"]
        head = model.vis.headlight
        for colour in (head.ambient, head.diffuse, head.specular):
            colour *= change["scale"]

    def shift_camera(self, env: Any, change: dict[str, Any], hand: Any) -> None:
        """Displace a camera, and turn it about the vertical."""
        model = env.sim.model._model
        camera, half = model.camera(change["camera"]).id, math.radians(change["yaw_degrees"]) / 2
        turned = np.zeros(4)
        mujoco.mju_mulQuat(turned, np.array([math.cos(half), 0.0, 0.0, math.sin(half)]), model.cam_quat[camera])
        model.cam_quat[camera] = turned
        model.cam_pos[camera] += change["delta_position_m"]

    def replace_instruction(self, env: Any, change: dict[str, Any], hand: Any) -> None:
        """Replace the goal; the benchmark checks the new one from then on."""
        self.sentence = change.get("instruction", "")
        self.goal = [[g["predicate"].lower(), *g["arguments"]] for g in change["alternate_goal"]]
        env.parsed_problem["goal_state"] = self.goal

    def cancel_instruction(self, env: Any, change: dict[str, Any], hand: Any) -> None:
        """Cancel the task: the goal is empty from then on."""
        self.sentence, self.goal = change.get("instruction", ""), []
        self.way = [hand.tolist()]
        self.rested = origin(env, self.scenario["trigger"]["value"])


def body_of(env: Any, name: str) -> int:
    """Id of the body of an object or fixture."""
    return int(env.obj_body_id[name]) if name in env.obj_body_id else int(env.sim.model.body_name2id(env.get_object(name).root_body))


def origin(env: Any, name: str) -> Any:
    """Origin of a thing in the world [m]."""
    return np.array(env.sim.data.body_xpos[body_of(env, name)])


def put(env: Any, name: str, place: Any) -> None:
    """Move a thing to a position, with zero velocity if it has a free joint."""
    model, data, body = env.sim.model, env.sim.data, body_of(env, name)
    joint = int(model.body_jntadr[body])
    if joint >= 0 and int(model.jnt_type[joint]) == 0:
        address, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        data.qpos[address : address + 3] = place
        data.qvel[dof : dof + 6] = 0.0
        return
    model.body_pos[body] = np.array(model.body_pos[body]) + np.array(place) - origin(env, name)


def solid(env: Any, name: str, here: bool) -> None:
    """Switch a thing's collisions and weight on or off; without them an absent thing stays where it was put."""
    model, body = env.sim.model, body_of(env, name)
    inside = [b for b in range(model.nbody) if _within(model, b, body)]
    for geom in range(model.ngeom):
        if int(model.geom_bodyid[geom]) in inside:
            store = env.__dict__.setdefault("_solid", {})
            store.setdefault(geom, (int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])))
            model.geom_contype[geom], model.geom_conaffinity[geom] = store[geom] if here else (0, 0)
    for b in inside:
        model._model.body_gravcomp[b] = 0.0 if here else 1.0


def _within(model: Any, body: int, top: int) -> bool:
    while body > 0 and body != top:
        body = int(model.body_parentid[body])
    return body == top
