"""Robot code under load: mutated programs through the parser and checker, the interpreter, and the controller against raw physics.

``python tests/benchmarks/robot_code.py mutations --count 100000 --seed 0``: every mutated program is either accepted or refused
with a line; nothing else may happen, and none may take longer than ``SLOW`` of processor time.
``python tests/benchmarks/robot_code.py speed [--script FILE]``: statements a second, control cycles against raw physics steps, and
how long a file takes to parse and check (ur_rtde's control script, as it is received on the wire).
"""

from __future__ import annotations

import argparse
import random
import re
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from figure import add_figure, rate, value, write

from cramlite.experiment.figure import Number
from cramlite.plugin import UserError
from cramlite_plugins.backends.urscript.flow import FUNCTIONS as FLOW
from cramlite_plugins.backends.urscript.parts import FUNCTIONS
from cramlite_plugins.backends.urscript.search import FUNCTIONS as SEARCH

SLOW = 2.0  # processor time of one program [s]
TOKENS = ("def", "thread", "end", "if", "while", "(", ")", "[", "]", "p[", ":", "=", "==", ",", "1", "1e400", '"', "#", "\n",
          "local", "global", "return", "run", "kill", "not", "-", "*", "%", "True", "movel", "halt", "\t", "\x00", "ü", "sec")  # fmt: skip


def sources() -> list[str]:
    """Programs of one function each with the functions that it calls, of cramlite's own text: 30 to 120 lines."""
    heads = [m for text in (FUNCTIONS, SEARCH, FLOW) for m in re.findall(r"^(?:def|thread) .*?^end$", text, re.M | re.S)]
    every = {re.match(r"\w+ (\w+)", h)[1]: h for h in heads}  # type: ignore[index]
    globals_ = [m for text in (FUNCTIONS, SEARCH, FLOW) for m in re.findall(r"^global .*$", text, re.M)]
    return ["def p():\n" + "\n".join([*globals_, *_needed(name, every), "end", ""]) for name in every]


def _needed(name: str, every: dict[str, str]) -> list[str]:
    """A function, and before it the functions that it calls."""
    found, waiting = {name: every[name]}, [name]
    while waiting:
        for other in re.findall(r"\b(\w+)\(", every[waiting.pop()]):
            if other in every and other not in found:
                found[other] = every[other]
                waiting.append(other)
    return list(reversed(found.values()))


def mutated(text: str, random_: random.Random) -> str:
    """One to four changes: a letter, a word, a line, or a piece moved elsewhere."""
    for _ in range(random_.randint(1, 4)):
        at, what = random_.randrange(len(text) + 1), random_.randrange(7)
        lines = text.split("\n")
        k = random_.randrange(len(lines))
        if what == 0:
            text = text[:at] + text[at + 1 :]
        elif what == 1:
            text = text[:at] + random_.choice(TOKENS) + text[at:]
        elif what == 2:
            text = text[:at] + chr(random_.choice((random_.randrange(32, 127), random_.randrange(1, 0x2FF)))) + text[at + 1 :]
        elif what == 3:
            text = "\n".join(lines[:k] + lines[k + 1 :])
        elif what == 4:
            text = "\n".join([*lines[:k], lines[random_.randrange(len(lines))], *lines[k:]])
        elif what == 5:
            text = text[:at] + random_.choice(TOKENS) * random_.randint(2, 40) + text[at:]
        else:
            words = text.split(" ")
            i, j = random_.randrange(len(words)), random_.randrange(len(words))
            words[i], words[j] = words[j], words[i]
            text = " ".join(words)
        text = text or " "
    return text


def judged(count: int, seed: int) -> Iterator[tuple[str, str, float]]:
    """What became of each program: (outcome, message, processor time)."""
    from cramlite_plugins.ur_controller.functions import known_functions
    from cramlite_plugins.ur_controller.urscript.doubts import doubts
    from cramlite_plugins.ur_controller.urscript.interpreter import load
    from cramlite_plugins.ur_controller.urscript.kinds import wrong_kinds

    library, random_, texts = known_functions(), random.Random(seed), sources()
    for _ in range(count):
        text = mutated(random_.choice(texts), random_)
        begin = time.process_time()
        try:
            tree = load(text, library).tree
            list(wrong_kinds(tree)), doubts(tree)
            outcome, said = "accepted", ""
        except UserError as error:
            said = str(error)
            outcome = "refused with a line" if re.search(r"\blines? \d", said) else "refused without a line"
        except Exception as error:
            outcome, said = "crashed", f"{type(error).__name__}: {error}\n{text}"
        yield outcome, said, time.process_time() - begin


def mutations(options: argparse.Namespace) -> int:
    """Print what became of the programs; 1 if anything did that must not."""
    count, seed = options.count, options.seed
    found: Counter[str] = Counter()
    slowest, total, wrong = 0.0, 0.0, []
    for outcome, said, spent in judged(count, seed):
        found[outcome] += 1
        slowest, total = max(slowest, spent), total + spent
        if outcome in ("crashed", "refused without a line"):
            wrong.append(f"{outcome}: {said[:600]}")
    for text in wrong[:5]:
        print(text)
    print(f"{count} mutated programs, seed {seed}: {dict(found)}; {total:.0f} s of processor time, slowest {slowest * 1000:.0f} ms")
    write(options, [*(rate(o, n, count) for o, n in found.items()), value("slowest", 1000 * slowest, "ms")], f"seed {seed}")
    return int(bool(wrong) or slowest > SLOW)


LOOP = "def p():\n  i = 0\n  while i < 500000:\n    i = i + 1\n  end\nend\n"


def speed(script: Path | None) -> list[Number]:
    """Print figures; all in processor time, so that a busy machine does not count."""
    from cramlite_plugins.ur_controller.functions import known_functions
    from cramlite_plugins.ur_controller.urscript.interpreter import Limits, Machine, load

    machine = Machine(load(LOOP), limits=Limits(slice=10**9, statements=10**9))
    begin = time.process_time()
    while not machine.finished:
        machine.cycle()
    print(f"interpreter: {machine.total} statements in {(took := time.process_time() - begin):.2f} s")
    numbers = [value("interpreter", machine.total / took, "statements a second")]
    if script is not None:
        from cramlite_plugins.ur_controller.registers import Registers

        text, library = script.read_text(), {**known_functions(), **Registers(lambda: 0.0).library()}
        spent = []
        for _ in range(5):
            begin = time.process_time()
            load(text, library)
            spent.append(time.process_time() - begin)
        print(f"{script.name}: {len(text.splitlines())} lines parsed, checked and compiled in {min(spent) * 1000:.0f} ms")
        numbers.append(value("parse, check and compile", 1000 * min(spent), "ms", note=script.name))
    return [*numbers, *_controller()]


def _controller() -> list[Number]:
    """The controller at 500 Hz while it moves, and the same number of bare physics steps of the same model."""
    import mujoco

    from cramlite.model import Pose, RobotMount, World
    from cramlite_plugins.objects.products_and_fixtures import table
    from cramlite_plugins.robots.ur5e import UR5E
    from cramlite_plugins.ur_controller.virtual_robot import VirtualRobot

    world = World((table("floor", Pose((0.4, 0, -0.001))),), (RobotMount("arm", "ur5e"),))
    robot, cycles = VirtualRobot(world, {"ur5e": UR5E}, "arm", lambda _: None), 5000
    away = [UR5E.home[0] + 1.0, *UR5E.home[1:]]
    robot.receive(f"def p():\n  while True:\n    movej({away})\n    movej({list(UR5E.home)})\n  end\nend\n")
    begin = time.process_time()
    for _ in range(cycles):
        robot.cycle()
    controlled = time.process_time() - begin
    model, data = robot.compiled.model, robot.compiled.data()
    begin = time.process_time()
    for _ in range(cycles):
        mujoco.mj_step(model, data)
    raw = time.process_time() - begin
    print(f"controller: {cycles / controlled:.0f} cycles a second, raw physics: {cycles / raw:.0f} steps a second "
          f"({controlled / raw:.1f} times as long), real time is 500")  # fmt: skip
    return [value("controller", cycles / controlled, "cycles a second"), value("controller / mj_step", controlled / raw)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    mutate = commands.add_parser("mutations")
    mutate.add_argument("--count", type=int, default=100_000)
    mutate.add_argument("--seed", type=int, default=0)
    measure = commands.add_parser("speed")
    measure.add_argument("--script", type=Path)
    add_figure(mutate)
    add_figure(measure)
    arguments = parser.parse_args()
    if arguments.command == "mutations":
        return mutations(arguments)
    write(arguments, speed(arguments.script))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
