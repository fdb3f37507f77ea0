"""The virtual UR controller, driven over its ports: by the unmodified ur_rtde client, and by rude ones."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cramlite_plugins.ur_controller.dashboard import TOO_EARLY
from cramlite_plugins.ur_controller.rtde import FORMATS, INPUTS, OUTPUTS, Recipe, packet, recipe, type_of
from cramlite_plugins.ur_controller.urscript.interpreter import Machine, Stopped, load

HOST = "127.0.0.31"


@pytest.fixture(scope="module")
def controller(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A controller process; its log."""
    log = tmp_path_factory.mktemp("controller") / "log"
    command = [sys.executable, "-m", "cramlite", "controller", "--host", HOST, "--seconds", "240"]
    with log.open("w") as out, subprocess.Popen(command, stdout=out, stderr=out) as process:
        for _ in range(600):
            if "Ready" in log.read_text():
                break
            assert process.poll() is None, log.read_text()
            time.sleep(0.1)
        yield log
        process.terminate()


def ask(port: int, *lines: str) -> list[str]:
    with socket.create_connection((HOST, port), timeout=10) as connection:
        stream = connection.makefile("rw", newline="\n")
        said = [stream.readline()] if port == 29999 else []
        for line in lines:
            stream.write(line + "\n")
            stream.flush()
            said.append(stream.readline())
    return [s.strip() for s in said]


def send(port: int, data: bytes) -> None:
    with socket.create_connection((HOST, port), timeout=10) as connection:
        connection.sendall(data)


def until(holds: Callable[[], bool], seconds: float = 20.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if holds():
            return True
        time.sleep(0.02)
    return False


def wait_for(log: Path, text: str) -> bool:
    return until(lambda: text in log.read_text())


@pytest.mark.heavy
@pytest.mark.skipif(sys.version_info >= (3, 13), reason="ur_rtde has wheels for 3.11 and 3.12")
def test_the_unmodified_client_drives_it(controller: Path) -> None:
    """Connect, receive, moveJ, moveL, forceMode, zeroFtSensor, setPayload, custom script, servoJ, stop.

    The client sends its own control script of more than a thousand lines through the script port: it is taken from the
    wire, as the controller receives it. In the wheel it is kept as single lines inside the shared object.
    """
    import rtde_control
    import rtde_receive

    control = rtde_control.RTDEControlInterface(HOST)
    receive = rtde_receive.RTDEReceiveInterface(HOST)
    home = receive.getActualQ()
    aside = [home[0] + 0.3, *home[1:]]
    assert control.moveJ(aside, 1.05, 1.4)
    assert until(lambda: receive.getActualQ() == pytest.approx(aside, abs=0.01))
    place = receive.getActualTCPPose()
    up = [*place[:2], place[2] + 0.05, *place[3:]]
    assert control.moveL(up, 0.25, 1.2)
    assert until(lambda: receive.getActualTCPPose()[:3] == pytest.approx(up[:3], abs=0.003))
    assert control.zeroFtSensor()
    assert control.forceMode([0.0] * 6, [0, 0, 1, 0, 0, 0], [0, 0, -5.0, 0, 0, 0], 2, [0.1, 0.1, 0.02, 0.1, 0.1, 0.1])
    assert until(lambda: receive.getActualTCPPose()[2] < up[2] - 0.003), (
        "nothing in the way: the tool follows the force"
    )
    assert control.forceModeStop()
    assert control.setPayload(1.2, [0.0, 0.0, 0.1]) and until(lambda: abs(receive.getPayload() - 1.2) < 1e-9)
    assert control.sendCustomScriptFunction("greet", '  textmsg("greetings from a custom script")\n')
    assert wait_for(controller, "greetings from a custom script")
    target = receive.getActualQ()
    for _ in range(50):
        target[0] -= 0.002
        control.servoJ(target, 0.0, 0.0, 0.002, 0.1, 300)
        time.sleep(0.004)
    assert control.servoStop()
    assert control.moveJ(home, 0.3, 0.5, True)
    time.sleep(0.2)
    control.stopJ(2.0)
    assert control.getInverseKinematics(up) and control.isConnected() and receive.getSafetyMode() == 1
    control.stopScript()
    assert wait_for(controller, "RTDE Control Script Terminated")


def test_the_dashboard_answers(controller: Path) -> None:
    said = ask(29999, "PolyscopeVersion", "stop", "safetystatus", "running", "no such thing", "quit")
    assert said[0].startswith("Connected") and said[1].startswith("URSoftware 5.12")
    assert said[2:] == [
        "Stopped",
        "Safetystatus: NORMAL",
        "Program running: false",
        "could not understand: 'no such thing'",
        "Disconnected",
    ]


def test_a_program_that_is_wrong_is_refused_and_the_next_one_runs(controller: Path) -> None:
    send(30002, b"def wrong():\n  no_such_function(1)\nend\n")
    assert wait_for(controller, "there is no function 'no_such_function'")
    send(30001, b'def right():\n  textmsg("right after wrong")\nend\n')
    assert wait_for(controller, "right after wrong")


@pytest.mark.parametrize(("kind", "height"), [("movej", 0.4), ("movep", 0.45)])
def test_a_blend_that_nothing_follows_ends_at_its_target(controller: Path, kind: str, height: float) -> None:
    send(30002, f"{kind}(p[0.4, -0.2, {height}, 0, 3.14, 0], a=2, v=1, r=0.02)\n".encode())
    for _ in range(100):
        time.sleep(0.1)
        if ask(29999, "running")[1].endswith("false"):
            break
    send(30002, f'def well():\n  textmsg("{kind} ended at ", get_target_tcp_pose()[2])\nend\n'.encode())
    assert wait_for(controller, f"{kind} ended at {height:g}")


def test_a_protective_stop_ends_the_program_until_it_is_unlocked(controller: Path) -> None:
    send(30003, b"def pause():\n  protective_stop()\nend\n")
    assert wait_for(controller, "protective stop: the program asked for it")
    assert ask(29999, "safetystatus")[1] == "Safetystatus: PROTECTIVE_STOP"
    send(30003, b'def later():\n  textmsg("must not run")\nend\n')
    assert wait_for(controller, "unlock it at the dashboard") and "s  must not run" not in controller.read_text()
    assert ask(29999, "unlock protective stop", "safetystatus")[1:] == [TOO_EARLY, "Safetystatus: PROTECTIVE_STOP"]
    assert until(lambda: ask(29999, "unlock protective stop")[1] == "Protective stop releasing")
    assert ask(29999, "safetystatus")[1] == "Safetystatus: NORMAL"
    send(30003, b'def later():\n  textmsg("runs again")\nend\n')
    assert wait_for(controller, "s  runs again")


def test_without_power_no_program_runs(controller: Path) -> None:
    assert ask(29999, "power off", "robotmode")[2] == "Robotmode: POWER_OFF"
    send(30003, b'def dark():\n  textmsg("nobody sees this")\nend\n')
    assert wait_for(controller, "the brakes are on; 'power on' and 'brake release'")
    assert ask(29999, "power on", "robotmode", "brake release", "robotmode")[2::2] == ["Robotmode: IDLE", "Robotmode: RUNNING"]
    assert "s  nobody sees this" not in controller.read_text()
    assert ask(29999, "load a.urp", "play")[1:] == ["File not found: a.urp", "Failed to execute: play"]


def test_the_gripper_has_its_server(controller: Path) -> None:
    with socket.create_connection((HOST, 63352), timeout=10) as connection:
        connection.sendall(b"SET POS 255\n")
        assert connection.recv(16) == b"ack"
        for _ in range(200):
            connection.sendall(b"GET POS\n")
            if int(connection.recv(16).split()[1]) > 220:
                break
            time.sleep(0.05)
        else:
            pytest.fail("the fingers did not close")
        connection.sendall(b"SET POS 0\n")


@pytest.mark.parametrize("port", [30004, 29999, 30002, 63352])
def test_rude_clients_harm_nobody(controller: Path, port: int) -> None:
    """Nonsense, half a packet, a huge size, clients that hang up or stay silent."""
    half = b"def half():\n  x = 1\n"
    for data in (b"\xff" * 3000, b"\x00\x05V", b"\x00\x00\x00", b"\xff\xffU", b"\n" * 50, b"A" * 200_000 + b"\n", half, b""):
        try:
            send(port, data)
        except OSError:
            continue  # sent away while it was still sending: as it should be
    silent = [socket.create_connection((HOST, port), timeout=10) for _ in range(8)]
    assert ask(29999, "robotmode")[1] == "Robotmode: RUNNING"
    for connection in silent:
        connection.close()


def test_too_many_clients_are_sent_away(controller: Path) -> None:
    many = [socket.create_connection((HOST, 29999), timeout=10) for _ in range(40)]
    greeted = [bool(c.recv(8)) for c in many]
    for connection in many:
        connection.close()
    assert 20 <= sum(greeted) <= 32
    time.sleep(0.5)
    assert ask(29999, "robotmode")[1] == "Robotmode: RUNNING"


@pytest.mark.parametrize(("action", "running"), [("stop", False), ("ignore", True)])
def test_a_watchdog_that_nobody_feeds_stops_the_program(controller: Path, action: str, running: bool) -> None:
    loop = "  while True:\n    sync()\n  end\nend\n"
    send(30002, f'def fed():\n  rtde_set_watchdog("input_int_register_5", 10, "{action}")\n{loop}'.encode())
    until(lambda: "'input_int_register_5' was not written in time" in controller.read_text(), 0.0 if running else 20.0)
    time.sleep(0.5)
    assert ask(29999, "running")[1] == f"Program running: {str(running).lower()}"
    ask(29999, "stop")


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("host", "said"), [("0.0.0.0", "loopback addresses only"), ("10.1.2.3", "loopback"), (HOST, "cannot be opened")]
)
def test_other_addresses_are_refused(controller: Path, host: str, said: str) -> None:
    command = [sys.executable, "-m", "cramlite", "controller", "--host", host, "--seconds", "5"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and said in done.stderr and "Traceback" not in done.stderr


@pytest.mark.heavy
def test_it_closes_by_itself() -> None:
    command = [sys.executable, "-m", "cramlite", "controller", "--host", "127.0.0.32", "--idle", "0.5"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0 and "nobody was connected for 0.5 s" in done.stdout


FIELDS = st.lists(st.sampled_from(sorted({**OUTPUTS, **INPUTS})), min_size=1, max_size=10, unique=True)


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(FIELDS, st.data())
def test_packets_are_read_back_as_written(names: list[str], data: st.DataObject) -> None:
    kinds = tuple({**OUTPUTS, **INPUTS}[n] for n in names)
    fields = Recipe(1, tuple(names), kinds)
    values = {n: data.draw(_value(k)) for n, k in zip(names, kinds, strict=True)}
    assert fields.unpack(fields.pack(values)) == values


def _value(kind: str) -> st.SearchStrategy[object]:
    shape = FORMATS[kind]
    letter = shape[-1]
    bits = {"B": 8, "I": 32, "Q": 64}
    number: st.SearchStrategy[object] = (
        st.floats(allow_nan=False) if letter == "d" else st.booleans() if letter == "?"
        else st.integers(-(2**31), 2**31 - 1) if letter == "i" else st.integers(0, 2 ** bits[letter] - 1)
    )  # fmt: skip
    return st.lists(number, min_size=int(shape[0]), max_size=int(shape[0])) if shape[0].isdigit() else number


def test_unknown_fields_are_named_as_such() -> None:
    found = recipe(3, "actual_q,no_such_field,", output=True)
    assert found.types == ("VECTOR6D", "NOT_FOUND") and not found.complete
    assert type_of("input_int_register_47", output=False) == "INT32"
    assert type_of("input_int_register_48", output=False) == "NOT_FOUND"
    assert type_of("output_int_register_0", output=False) == "NOT_FOUND"
    assert packet("V", b"\x01") == b"\x00\x04V\x01"


@pytest.mark.parametrize(("handle", "runs"), [("0", True), ("7", False)])
def test_a_thread_that_was_never_started_may_be_killed(handle: str, runs: bool) -> None:
    machine = Machine(load(f"def p():\n  thrd = {handle}\n  kill thrd\nend\n"))
    if runs:
        machine.cycle()
        assert machine.finished
    else:
        with pytest.raises(Stopped, match="needs a thread's handle"):
            machine.cycle()
