"""Model files of the kinds of things in LIBERO's 130 tasks, one folder each, for ``cramlite library add``.

It runs in LIBERO's environment, before any episode: ``~/.local/share/cramlite/libero/bin/python kinds.py FOLDER``. A kind is written as
LIBERO assembles it: names made unique, masses stated, and the files that it names copied beside it. FOLDER/z and FOLDER/y have those of
which that axis usually points up, FOLDER/any the others, and FOLDER/robot the meshes of the robot.
"""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))
from masses import with_masses
from robot_meshes import write_robot

SUITES = ("libero_spatial", "libero_object", "libero_goal", "libero_10", "libero_90")
OWN = "kindsownname"
"""Placeholder for the object's name while its model is assembled; no file contains this text."""
FILE = re.compile(r'\bfile="([^"]+)"')
UP = {
    "y": ("alphabet_soup", "ketchup", "milk", "new_salad_dressing", "orange_juice", "salad_dressing", "tomato_sauce"),
    "any": ("bbq_sauce", "black_book", "butter", "chocolate_pudding", "cookies", "cream_cheese", "yellow_book"),
}  # fmt: skip
"""Axis that usually points up, for the kinds whose upward axis is not z, by common knowledge of cans, bottles and boxes."""
SURROUNDINGS = ("table", "floor")
"""Kinds of fixtures that a room is made of: tables and floors."""


def named_kinds() -> dict[str, bool]:
    """Return a dictionary from each kind of thing that LIBERO's problem files name to whether it is a fixture."""
    from libero.libero import get_libero_path
    from libero.libero.envs import bddl_utils

    found: dict[str, bool] = {}
    for suite in SUITES:
        for path in sorted((Path(get_libero_path("bddl_files")) / suite).glob("*.bddl")):
            problem = bddl_utils.robosuite_parse_problem(str(path))
            found |= dict.fromkeys(problem["objects"], False)
            found |= {kind: True for kind in problem["fixtures"] if not kind.endswith(SURROUNDINGS)}
    return dict(sorted(found.items()))


def assembled(kind: str, fixture: bool) -> str:
    """Return a kind's model as MJCF, as the benchmark's simulator compiles it."""
    from libero.libero.envs.objects import OBJECTS_DICT
    from robosuite.models.world import MujocoWorldBase
    from robosuite.utils.binding_utils import MjSim

    thing: Any = OBJECTS_DICT[kind](name=OWN, **({"joints": None} if fixture else {}))
    world = MujocoWorldBase()
    world.merge_assets(thing)
    world.worldbody.append(thing.get_obj())
    sim = MjSim.from_xml_string(world.get_xml())
    return with_masses(sim.model.get_xml(), sim.model._model).replace(f"{OWN}_", "")


def write_kind(kind: str, fixture: bool, folder: Path) -> None:
    """Write a kind's file, and copy the meshes and pictures that it names beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    text = re.sub(r' (mesh|texture)dir="[^"]*"', "", assembled(kind, fixture))
    for number, file in enumerate(dict.fromkeys(FILE.findall(text))):
        own = f"{number}_{Path(file).name}"
        shutil.copyfile(file, folder / own)
        text = text.replace(f'"{file}"', f'"{own}"')
    (folder / f"{kind}.xml").write_text(text, encoding="utf-8")


def main() -> None:
    """Write the model files of all kinds of things, and print for which kinds the benchmark has no model."""
    out = Path(sys.argv[1])
    ups = {kind: up for up, some in UP.items() for kind in some}
    for kind, fixture in named_kinds().items():
        try:
            write_kind(kind, fixture, out / ups.get(kind, "z") / kind)
        except (KeyError, FileNotFoundError) as error:
            print(f"{kind}: left out, since LIBERO has no model file of it ({error})")
        else:
            print(f"{kind}: {'a fixture' if fixture else 'an object'}")
    write_robot(out / "robot")
    print("robot: the meshes that cameras see of it")


if __name__ == "__main__":
    main()
