"""The MuJoCo simulator as a plugin: it executes, demonstrates, looks and takes pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from cramlite.model import Robot, Rollout, World
from cramlite.plugin import ModelMaker, Simulator, hookimpl

if TYPE_CHECKING:
    from cramlite.model import Camera, Pose, Scene, Thing, View


class MujocoSimulator:
    """Physics by MuJoCo; URScript by the controller model of this package."""

    name = "mujoco"

    def check(self, world: World, robots: Mapping[str, Robot]) -> None:
        from .model.no_window import import_mujoco

        import_mujoco()
        from .model.compile import compile_world

        compile_world(world, robots)

    def doubts(self, world: World, robots: Mapping[str, Robot]) -> Iterable[tuple[str, str]]:
        """Things of a world that are odd at its start, and why."""
        from .model.world_doubts import world_doubts

        return world_doubts(world, robots)

    def execute(self, text: str, world: World, robots: Mapping[str, Robot], *, mount: str, seed: int) -> Rollout:
        from .execute import execute
        from .ur.client_program import execute_client, is_client_program

        if is_client_program(text):
            return execute_client(text, world, robots, mount=mount, seed=seed)
        return execute(text, world, robots, mount=mount, seed=seed)

    def inspect(self, text: str) -> Iterable[tuple[int, str]]:
        from .ur.functions import known_functions
        from .urscript.doubts import doubts
        from .urscript.interpreter import load
        from .urscript.kinds import wrong_kinds

        tree = load(text, known_functions()).tree
        return [(d.line, d.text) for d in (*wrong_kinds(tree), *doubts(tree))]

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
        from .ur.network import serve
        from .ur.virtual_robot import VirtualRobot

        return serve(VirtualRobot(world, robots, mount, say, seed=seed), host, seconds=seconds, idle=idle, ready=say)

    def look(self, world: World, robots: Mapping[str, Robot], camera: Camera, *, seed: int) -> View:
        from .camera.depth_camera import look

        return look(world, robots, camera, seed=seed)

    def demonstrate(self, world: World, script: str, *, seed: int) -> Rollout:
        from .person.demonstrate import demonstrate

        return demonstrate(world, script=script, seed=seed)

    def picture(self, rollout: Rollout, sample: int, robots: Mapping[str, Robot], size: tuple[int, int]) -> Any:
        from .recording.pictures import picture

        return picture(rollout, sample, robots, size)

    def scene(self, rollout: Rollout, robots: Mapping[str, Robot], samples: Sequence[int]) -> Scene:
        from .recording.pictures import scene

        return scene(rollout, robots, samples)


def _maker(name: str) -> ModelMaker:
    def make(*, name: str, pose: Pose, model: str = name, **parameters: object) -> Thing:
        from .objects.products_and_fixtures import make as make_thing

        return make_thing(model, name, pose, parameters)

    def hang(thing: Thing, hanger: Thing, depth: float, yaw: float) -> Pose:
        from .objects.products_and_fixtures import hung

        return hung(thing, hanger, depth, yaw)

    return ModelMaker(name, make, hang, ("file",) if name == "mesh" else ())


@hookimpl
def simulators() -> Iterable[Simulator]:
    return [MujocoSimulator()]


@hookimpl
def object_models() -> Iterable[ModelMaker]:
    from .objects.products_and_fixtures import MODELS

    return [_maker(name) for name in MODELS]
