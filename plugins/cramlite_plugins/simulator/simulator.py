"""The MuJoCo simulator as a plugin: it executes, demonstrates, looks and takes pictures."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from cramlite.model import Robot, Rollout, Watch, World
from cramlite.plugin import ModelMaker, RecordScript, Shown, Simulator, hookimpl

if TYPE_CHECKING:
    from cramlite.model import Camera, Collision, Pose, Scene, Thing, View


class MujocoSimulator:
    """The MuJoCo simulator; URScript runs on the controller model of this package."""

    name = "mujoco"

    def check(self, world: World, robots: Mapping[str, Robot]) -> None:
        """Check that a world compiles, and that no thing in it begins deep inside another, or inside a link of an arm."""
        from ..simulation.model.no_window import import_mujoco

        import_mujoco()
        from ..simulation.model.compile import compile_world
        from ..simulation.model.world_doubts import refuse_overlaps

        compiled = compile_world(world, robots)
        refuse_overlaps(compiled, compiled.data())

    def doubts(self, world: World, robots: Mapping[str, Robot]) -> Iterable[tuple[str, str]]:
        """List things of a world that are implausible at its start, with reasons."""
        from ..simulation.model.world_doubts import world_doubts

        return world_doubts(world, robots)

    def put_apart(
        self, world: World, robots: Mapping[str, Robot], most: float, deep: float | None = None, staying: bool = False
    ) -> tuple[World, tuple[str, ...]]:
        """Move loose things that overlap others to free places, at most ``most`` away [m]; return the world
        and a text on each move."""
        from ..simulation.model.put_apart import put_apart
        from ..simulation.model.world_doubts import TOO_DEEP

        return put_apart(world, robots, most, TOO_DEEP if deep is None else deep, staying)

    def execute(
        self, text: str, world: World, robots: Mapping[str, Robot], *, mount: str, seed: int, watch: Watch | None = None
    ) -> Rollout:
        """Run a program's text in a world."""
        from ..ur_controller.client_text import is_client_program
        from .execute import execute

        if is_client_program(text):
            from ..ur_controller.client_program import execute_client

            return execute_client(text, world, robots, mount=mount, seed=seed)
        return execute(text, world, robots, mount=mount, seed=seed, watch=watch)

    def inspect(self, text: str) -> Iterable[tuple[int, str]]:
        """List the lines of a URScript program that are doubtful, or that the virtual controller cannot
        run, with reasons."""
        from ..ur_controller.functions import known_functions
        from ..ur_controller.urscript.check import by_reason
        from ..ur_controller.urscript.doubts import doubts
        from ..ur_controller.urscript.interpreter import examine
        from ..ur_controller.urscript.kinds import wrong_kinds

        loaded, lacks = examine(text, known_functions())
        found = [(d.line, d.text) for d in (*wrong_kinds(loaded.tree), *doubts(loaded.tree))]
        return sorted({*found, *((lack.line, f"cannot run here: {lack.text}") for lack in by_reason(lacks))})

    def serve(
        self,
        world: World,
        robots: Mapping[str, Robot],
        *,
        mount: str,
        host: str,
        seconds: float,
        idle: float,
        seed: int,
        say: Callable[[str], None],
    ) -> str:
        """Serve a virtual robot on the network; return why it ended."""
        from ..ur_controller.network import serve
        from ..ur_controller.virtual_robot import VirtualRobot

        return serve(VirtualRobot(world, robots, mount, say, seed=seed), host, seconds=seconds, idle=idle, ready=say)

    def look(self, world: World, robots: Mapping[str, Robot], camera: Camera, *, seed: int) -> View:
        """Render a camera's view of a world."""
        from ..simulation.camera.depth_camera import look

        return look(world, robots, camera, seed=seed)

    def demonstrate(self, world: World, shown: Sequence[Shown], *, seed: int) -> Rollout:
        """Record a scripted person's demonstration in a world."""
        from ..person.demonstrate import demonstrate

        return demonstrate(world, shown, seed=seed)

    def picture(
        self, rollout: Rollout, sample: int, robots: Mapping[str, Robot], size: tuple[int, int], about: Collection[str] = ()
    ) -> Any:
        """Render one sample of a rollout."""
        from ..simulation.recording.pictures import picture

        return picture(rollout, sample, robots, size, about)

    def collision_picture(
        self, world: World, robots: Mapping[str, Robot], collision: Collision, size: tuple[int, int]
    ) -> Any:
        """Render the collision for which motion planning refused a state of the robot."""
        from ..simulation.recording.collision_pictures import collision_picture

        return collision_picture(world, robots, collision, size)

    def scene(self, rollout: Rollout, robots: Mapping[str, Robot], samples: Sequence[int]) -> Scene:
        """Build the scene of a rollout for a viewer."""
        from ..simulation.recording.pictures import scene

        return scene(rollout, robots, samples)


def _maker(name: str) -> ModelMaker:
    def make(*, name: str, pose: Pose, model: str = name, **parameters: object) -> Thing:
        from ..objects.products_and_fixtures import make as make_thing

        return make_thing(model, name, pose, parameters)

    def hang(thing: Thing, hanger: Thing, depth: float, yaw: float) -> Pose:
        from ..objects.products_and_fixtures import hung

        return hung(thing, hanger, depth, yaw)

    return ModelMaker(name, make, hang, ("file",) if name == "mesh" else ())


@hookimpl
def simulators() -> Iterable[Simulator]:
    """Declare the simulator."""
    return [MujocoSimulator()]


@hookimpl
def object_models() -> Iterable[ModelMaker]:
    """Declare the object models."""
    from ..objects.products_and_fixtures import MODELS

    return [_maker(name) for name in MODELS]


@hookimpl
def record_scripts() -> Iterable[RecordScript]:
    """Declare the scripts of the simulated person."""
    from ..person.scripts import shipped_scripts

    return shipped_scripts()
