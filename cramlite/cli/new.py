"""``cramlite new``: writes a package for a new plugin, or a suite of tests around robot programs."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..base.errors import UserError
from .arguments import Add


def _new(arguments: argparse.Namespace) -> int:
    from ..testing.robot_skeleton import robot_text, write_robot
    from ..testing.skeleton import skeleton_text, write_skeleton

    kind, name, arm = arguments.kind, arguments.name, arguments.arm
    if kind == "tests":
        return _new_tests(Path(name), arguments)
    if arm is None and (arguments.keys or arguments.gripper):
        raise UserError("--keys and --gripper are about a robot from a file: --from FILE.")
    if arm is None:
        print(skeleton_text(kind, write_skeleton(kind, name, arguments.out)))
        return 0
    if kind != "robot":
        raise UserError(f"--from names the file of a robot, and cannot be used for a {kind}.")
    written = write_robot(name, arm, arguments.keys, arguments.gripper, arguments.out)
    print(f"{skeleton_text(kind, written.files)}\n{robot_text(written)}")
    return 0


def _new_tests(folder: Path, arguments: argparse.Namespace) -> int:
    from ..plugin.catalogue import Knowledge
    from ..plugin.selection import INSTALLED
    from ..testing.suite_skeleton import suite_text, write_suite

    if arguments.arm or arguments.keys or arguments.gripper:
        raise UserError("--from, --keys and --gripper are about a robot; tests take the folder of your programs.")
    knowledge = Knowledge(INSTALLED.registry())
    print(suite_text(write_suite(folder, knowledge, arguments.out)))
    return 0


def add_commands(add: Add) -> None:
    """Add the command ``new``, with its arguments, to the command line."""
    new = add("new", _new, asks_plugins=False)
    new.add_argument(
        "kind", choices=["backend", "expert", "predicate", "robot", "task", "tests", "validator"],
        help="backend, expert, predicate, robot, task or validator; or tests, a suite around robot programs",
    )
    new.add_argument(
        "name", metavar="NAME",
        help="of the plugin, in small letters, such as wiping or no_spill; of tests, the folder of the "
            "programs",
    )
    new.add_argument(
        "--out", type=Path, metavar="DIR",
        help="the package's folder; default cramlite-NAME, of tests NAME/robot_tests",
    )
    new.add_argument(
        "--from", dest="arm", type=Path, metavar="FILE",
        help="of a robot: the MJCF or URDF of its arm, which is copied into the package; what was found in it "
            "is printed",
    )
    new.add_argument(
        "--gripper", type=Path, metavar="FILE",
        help="the MJCF or URDF of its gripper; else as --keys says, else a 2F-85",
    )
    new.add_argument(
        "--keys", type=Path, metavar="FILE",
        help="YAML with further keys of a scenario's robot, such as 'payload: 5 kg'",
    )
