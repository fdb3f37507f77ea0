"""LIBERO's simulator while a random problem is generated: it draws a state at random, and answers questions about it.

It runs in the benchmark's environment.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from drawn_goals import OPPOSITE, PLACES, Literal
from libero.libero.envs.env_wrapper import ControlEnv
from variants import Problem, movables

IDLE, REST = 10, 20
"""Number of idle actions at the start of an episode, and of those after them in which things must be at rest, at 20 Hz."""
STILL = 0.005
"""Largest displacement of a thing at rest during the ``REST`` idle actions [m]."""
MARGIN = 0.01
"""Share of a joint's range within which a joint position counts as a state of the joint."""


class World:
    """Benchmark's simulator with the scene of a problem file.

    Args:
        path: of the problem file.
        problem: as it was parsed.
        seed: of the state that is drawn.

    Raises:
        RandomizationError: things do not fit where they shall stand.
    """

    def __init__(self, path: Path, problem: Problem, seed: int) -> None:
        self.problem = problem
        np.random.seed(seed)
        self.env: Any = ControlEnv(
            bddl_file_name=str(path), has_offscreen_renderer=False, use_camera_obs=False, horizon=100_000, ignore_done=True, control_freq=20
        )  # fmt: skip
        self.things = movables(problem)
        self.known_corners: dict[str, Any] = {}
        self.known_geoms: dict[str, tuple[int, ...]] = {}

    @property
    def model(self) -> Any:
        """MuJoCo's model."""
        return self.env.sim.model._model

    @property
    def data(self) -> Any:
        """MuJoCo's data."""
        return self.env.sim.data._data

    def reset(self) -> None:
        """Set a new random state as LIBERO does at the start of an episode, drawn until every thing has found a place."""
        self.env.reset()

    def state(self) -> Any:
        """Return the state in the format of LIBERO's initial states."""
        return np.array(self.env.get_sim_state())

    def begin(self, state: Any) -> None:
        """Set a state, and take the idle actions that an episode begins with."""
        self.env.set_init_state(state)
        for _ in range(IDLE):
            self.env.step(np.zeros(7))

    def restless(self) -> str:
        """Return why no task can begin in the state, such as that a thing has fallen off the table; "" if all things rest on it."""
        before = self.places()
        for _ in range(REST):
            self.env.step(np.zeros(7))
        moved = np.linalg.norm(self.places() - before, axis=1).max()
        low = self.places()[:, 2].min() < self._bottom()
        return f"a thing moves by {1000 * moved:.0f} mm" if moved > STILL else "a thing has fallen down" if low else ""

    def _bottom(self) -> float:
        return float(self.env.env.workspace_offset[2]) - 0.05

    def places(self) -> Any:
        """Return the positions of all things in the world (n, 3) [m]."""
        return np.array([self.data.body(self.root(t)).xpos for t in self.things])

    def root(self, thing: str) -> str:
        """Return the name of a thing's root body in the model."""
        return str(self.env.env.get_object(thing).root_body)

    def holds(self, literal: Literal) -> bool:
        """Return whether the benchmark says that a literal of a goal holds."""
        return bool(self.env.env._eval_predicate(list(literal)))

    def holds_nearly(self, literal: Literal) -> bool:
        """Return whether a condition of a goal holds, or would hold if its thing's joint moved by a hundredth
        of its range."""
        if literal[0] in PLACES or self.holds(literal):
            return self.holds(literal)
        return any(self._nearly(literal, sign) for sign in (1, -1))

    def _nearly(self, literal: Literal, sign: int) -> bool:
        kept = self.data.qpos.copy()
        for joint in self.joints(literal[1]):
            low, high = self.model.jnt_range[joint]
            self.data.qpos[self.model.jnt_qposadr[joint]] += sign * MARGIN * (high - low)
        found = self.holds(literal)
        self.data.qpos[:] = kept
        mujoco.mj_forward(self.model, self.data)
        return found

    def joints(self, name: str) -> list[int]:
        """Return the joints by which the benchmark checks a predicate of a thing or a region."""
        env = self.env.env
        named = env.object_sites_dict[name] if name in env.object_sites_dict else env.get_object(name)
        return [int(self.model.joint(j).id) for j in named.joints or () if self.model.joint(j).type[0] != mujoco.mjtJoint.mjJNT_FREE]

    def articulated(self) -> dict[str, tuple[str, ...]]:
        """Return the predicates that the benchmark can check on each jointed region, and on each jointed fixture without such a region."""
        env = self.env.env
        parts = {n: s.parent_name for n, s in env.object_sites_dict.items() if getattr(s, "parent_name", None) and self.joints(n)}
        whole = {n: n for n in env.fixtures_dict if n not in parts.values() and self.joints(n)}
        return {n: asked for n, of in (parts | whole).items() if (asked := _asked(env.get_object(of), n == of))}

    def extents(self, thing: str) -> Any:
        """Return the extents of a thing along its own axes [m]."""
        return np.ptp(self.own_corners(thing), axis=0)

    def own_corners(self, thing: str) -> Any:
        """Return the corners of the boxes about a thing's colliding geoms, in its own frame [m]."""
        if thing not in self.known_corners:
            body = self.data.body(self.root(thing))
            self.known_corners[thing] = (self.corners(thing) - body.xpos) @ body.xmat.reshape(3, 3)
        return self.known_corners[thing]

    def footprint(self, literal: Literal) -> Any:
        """Return the horizontal extents [m] of the compartment or support in or on which a literal puts a
        thing."""
        predicate, _, name = literal
        site = self.env.env.object_sites_dict.get(name)
        if predicate == "in" and site is not None:
            turn = self.data.site(name).xmat.reshape(3, 3)
            return 2.0 * np.abs(turn @ self.model.site(name).size)[:2]
        bearer = name if site is None else getattr(site, "parent_name", None)
        return np.full(2, np.inf) if bearer is None else np.ptp(self.corners(bearer), axis=0)[:2]  # a table bears all

    def geoms(self, thing: str) -> tuple[int, ...]:
        """Return the geoms of a thing that collide."""
        if thing not in self.known_geoms:
            inside, model = self._inside(int(self.model.body(self.root(thing)).id)), self.model
            own = (g for g in range(model.ngeom) if int(model.geom_bodyid[g]) in inside)
            self.known_geoms[thing] = tuple(g for g in own if model.geom_contype[g] or model.geom_conaffinity[g])
        return self.known_geoms[thing]

    def _inside(self, root: int) -> set[int]:
        found = {root}
        for body in range(root + 1, self.model.nbody):
            if int(self.model.body_parentid[body]) in found:
                found.add(body)
        return found

    def corners(self, thing: str) -> Any:
        """Return the corners of the boxes about a thing's colliding geoms, in the world [m]."""
        return np.concatenate([self._box(g) for g in self.geoms(thing)])

    def _box(self, geom: int) -> Any:
        """Corners of the box about a geom, in the world."""
        aabb = self.model.geom_aabb[geom]
        signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        return (aabb[:3] + signs * aabb[3:]) @ self.data.geom_xmat[geom].reshape(3, 3).T + self.data.geom_xpos[geom]

    def close(self) -> None:
        """Close the simulator."""
        self.env.close()


def _asked(thing: Any, whole: bool) -> tuple[str, ...]:
    """The predicates that the benchmark can check on a thing's joints: "open", "close", "turnon", "turnoff"."""
    ranges = thing.object_properties.get("articulation", {})
    opens = ("open", "close") if ranges.get("default_open_ranges") else ()
    turns = ("turnon", "turnoff") if whole and ranges.get("default_turnon_ranges") else ()
    return (*opens, *turns)


def joint_value(world: World, literal: Literal) -> float:
    """Return a joint value for a wanted state: the end of LIBERO's range of that state that is farther from the
    opposite state."""
    env: Any = world.env.env
    site: Any = env.object_sites_dict.get(literal[1])
    thing = env.get_object(site.parent_name if site is not None else literal[1])
    ranges = thing.object_properties["articulation"]
    other = np.mean(ranges[f"default_{OPPOSITE[literal[0]]}_ranges"])
    return float(max(ranges[f"default_{literal[0]}_ranges"], key=lambda v: abs(v - other)))
