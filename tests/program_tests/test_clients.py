"""Clients of a controller under test: they lose it and come back, and go on after a protective stop, as a real one lets them."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite.program_tests.miss import ProgramFailure
from cramlite.program_tests.robot import ProgramRobot, TestPlace

pytestmark = pytest.mark.heavy
WORLD = "place_on_shelf"

SENDS = '''
import socket, sys, time

MOVES = "def go():\\n  movej([2.8, -1.7, 1.3, -1.2, -1.57, 1.3], a=2, v=2)\\n" \\
    "  movej([2.4, -1.7, 1.3, -1.2, -1.57, 1.3], a=1, v=%s)\\nend\\n"

def dashboard(*lines):
    with socket.create_connection((sys.argv[1], 29999), timeout=5) as connection:
        stream = connection.makefile("rw", newline="\\n")
        said = [stream.readline()]
        for line in lines:
            stream.write(line + "\\n")
            stream.flush()
            said.append(stream.readline())
    if not said[-1]:
        raise ConnectionError("the dashboard hung up")
    return said[-1].strip()

def send(speed):
    with socket.create_connection((sys.argv[1], 30002), timeout=5) as connection:
        connection.sendall((MOVES % speed).encode())
        time.sleep(0.2)

def wait():
    while dashboard("running").endswith("true"):
        time.sleep(0.1)
'''
PLAIN = f"{SENDS}\nsend(0.5)\nwait()\n"
RECOVERS = f'''{SENDS}
send(0.1)
while dashboard("safetystatus") != "Safetystatus: PROTECTIVE_STOP":
    time.sleep(0.05)
print("stopped", flush=True)
while dashboard("unlock protective stop") != "Protective stop releasing":
    time.sleep(0.2)
send(0.5)
wait()
'''
RECONNECTS = f'''{SENDS}
send(0.2)
for _ in range(100):
    try:
        wait()
        break
    except OSError:
        print("reconnects", flush=True)
        time.sleep(0.2)
'''
END = 2.4


def robot(folder: Path) -> ProgramRobot:
    return ProgramRobot(TestPlace("test_x.py::test_y", folder, folder / "pages"), WORLD)


def _arrives(folder: Path, text: str, **options: object) -> object:
    run = robot(folder).run(text, **options)  # type: ignore[arg-type]
    return run.ends().holds(lambda r: abs(float(r.joints[-1, 0]) - END) < 0.01, f"the first joint ends at {END} rad")


def test_a_program_that_speaks_to_the_ports_by_itself(tmp_path: Path) -> None:
    _arrives(tmp_path, PLAIN)


def test_a_protective_stop_is_recovered_from_by_who_does_it(tmp_path: Path) -> None:
    stop = [{"protective_stop": "1.5 s"}]
    _arrives(tmp_path, RECOVERS, faults=stop)
    with pytest.raises(ProgramFailure, match="protective stop"):
        _arrives(tmp_path, PLAIN, faults=stop)


def test_a_lost_connection_is_survived_by_who_reconnects(tmp_path: Path) -> None:
    lost = [{"connection": "1 s", "lasts": "1 s"}]
    run = robot(tmp_path).run(RECONNECTS, faults=lost)
    run.ends().logs("reconnects").holds(lambda r: abs(float(r.joints[-1, 0]) - END) < 0.01, "it arrives")
    with pytest.raises(ProgramFailure, match="error"):
        _arrives(tmp_path, PLAIN.replace("send(0.5)", "send(0.1)"), faults=lost)
