"""Common code of Python programs for ur_rtde: motions with limits and time-outs, the gripper, failures with
reasons.

The text below the line "# ---- " is copied into the programs that the backend ``ur_rtde`` writes, so that a program
is one file that needs nothing but Python and the package ur-rtde. It is a module so that it is checked like all others.

Only calls of ur_rtde 1.6 are used whose meaning is documented: asynchronous moveJ and moveL, stopL, forceMode of type 2 around
moveL. Time is the controller's own (RTDE "timestamp"), so that a slow machine on either side does not shorten a time-out.
"""

from __future__ import annotations

import contextlib
import math
import os
import socket
import sys
import threading
import time
from collections.abc import Callable, Sequence

from rtde_control import RTDEControlInterface
from rtde_io import RTDEIOInterface
from rtde_receive import RTDEReceiveInterface

# ---- arm and gripper: limits, time-outs and reasons for every motion ----
Vector = Sequence[float]
CYCLE = 0.002  # between two looks at the robot's state [s]
SILENT = 5.0  # a controller whose clock stands still for this long is gone [s]
GONE = 1.0  # and a command that still waits for it then is given up after so long [s]
ARRIVED = 0.05  # what the robot has sent is read by then [s]
TAKEN = 0.02  # the control script on the robot takes a command within some cycles [s]
SLOWER = 3.0  # how much longer than planned a free motion may take
LINE_REGISTER = 18  # input_int_register of RTDE: the program's line, for who watches from outside
BEGINS = 0  # the line after which the program's own text begins
WATCHDOG = 0.5  # how often the robot must hear from this program, else it stops [Hz]
GENTLE = 0.25  # acceleration of guarded and force-controlled motions [m/s2]


class Failed(Exception):
    """Failure of a step; a control step around it may try something else."""


class Aborted(Exception):
    """Failure after which the program cannot go on."""


class Tripped(Exception):
    """Raised by a control step, such as a monitor, to end the steps inside it early."""

    def __init__(self, by: object, reason: str) -> None:
        super().__init__(reason)
        self.by = by


def log(text: str) -> None:
    """Print a line of the program's log."""
    print(text, flush=True)


def gone(reason: str) -> None:
    """End the process at once when the robot no longer answers; ur_rtde's own shutdown would hang or crash."""
    out, silent = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):  # threads of ur_rtde print until the process ends, also in the middle of a line
        os.dup2(silent, stream)
    os.write(out, f"\ncramlite abort: {reason}\n".encode())
    os._exit(1)


class Gripper:
    """Connection to Robotiq's ASCII server on the robot (URCap), port 63352."""

    def __init__(self, host: str) -> None:
        self.lock = threading.Lock()
        try:
            self.connection = socket.create_connection((host, 63352), timeout=2.0)
        except OSError as error:
            raise Aborted(f"no gripper server at {host}:63352: {error}") from None

    def ask(self, line: str) -> str:
        """Send a line to the gripper and return its answer."""
        try:
            with self.lock:
                self.connection.sendall(f"{line}\n".encode("ascii"))
                return self.connection.recv(64).decode("ascii").strip()
        except OSError as error:
            raise Aborted(f"the gripper does not answer '{line}': {error}") from None

    def set(self, name: str, value: int) -> None:
        """Write a register of the gripper."""
        if (said := self.ask(f"SET {name} {value}")) != "ack":
            raise Aborted(f"the gripper does not acknowledge SET {name} {value}: '{said}'")

    def get(self, name: str) -> int:
        """Read a register of the gripper."""
        words = self.ask(f"GET {name}").split()
        if len(words) != 2 or not words[1].isdigit():
            raise Aborted(f"the gripper does not answer GET {name}: '{' '.join(words)}'")
        return int(words[1])


class Arm:
    """The robot, through ur_rtde. Poses are [x, y, z, rx, ry, rz] of the TCP in the base frame [m, rad].

    Args:
        force_limit: protective limit on the TCP force, at all times [N].
        zero: whether the controller can tare its own sensor (e-Series); else the program keeps the tare.
    """

    def __init__(self, host: str, force_limit: float, *, zero: bool = True) -> None:
        self.control, self.receive, self.io = RTDEControlInterface(host), RTDEReceiveInterface(host), RTDEIOInterface(host)
        self.gripper = Gripper(host)
        self.force_limit, self.can_zero = force_limit, zero
        self.tare = [0.0, 0.0, 0.0]
        self.guards: list[Callable[[], None]] = []
        self.seen, self.kicked = (0.0, time.monotonic()), 0.0
        self.ended = threading.Event()
        threading.Thread(target=self.listen, daemon=True).start()

    # What it measures

    def time(self) -> float:
        """The controller's clock [s]."""
        return float(self.receive.getTimestamp())

    def tcp(self) -> list[float]:
        """Pose of the TCP."""
        return list(self.receive.getActualTCPPose())

    def force(self) -> list[float]:
        """Force of the environment on the tool [N], base axes: the sensor's reading less its value at the
        last tare."""
        return [f - t for f, t in zip(self.receive.getActualTCPForce()[:3], self.tare, strict=True)]

    # What must hold at all times

    def guard(self) -> None:
        """Raise an error if the robot is silent or stopped, or exceeds the force limit; called in each cycle of a wait.

        Raises:
            Aborted: the force limit of the program, a protective stop, or a robot that no longer answers.
            Tripped: a control step wants an end.
        """
        now = self.time()
        if now != self.seen[0]:
            self.seen = now, time.monotonic()
        elif time.monotonic() - self.seen[1] > SILENT or not self.receive.isConnected():
            raise Aborted(f"nothing was heard from the robot for {SILENT:g} s")
        if self.receive.isProtectiveStopped() or self.receive.isEmergencyStopped():
            raise Aborted("the robot has stopped itself: protective or emergency stop")
        if (measured := math.hypot(*self.force())) > self.force_limit:
            raise Aborted(f"force {measured:.3f} N > {self.force_limit:g} N")
        if time.monotonic() - self.kicked > 0.1:
            self.kicked = time.monotonic()
            self.control.kickWatchdog()
        for guard in self.guards:
            guard()

    def wait(self, done: Callable[[], bool], timeout: float) -> float:
        """Wait until a condition holds; return the time waited [s], which is more than ``timeout`` if it never did."""
        begin = self.time()
        while not done():
            self.guard()
            if (waited := self.time() - begin) > timeout:
                return waited
            time.sleep(CYCLE)
        return min(self.time() - begin, timeout)

    def at(self) -> None:
        """Begin a step: write its line number in the program to an input register, which other programs can read."""
        self.guard()
        frame = sys._getframe(1)
        while frame.f_back is not None and frame.f_lineno < BEGINS:
            frame = frame.f_back
        self.io.setInputIntRegister(LINE_REGISTER, frame.f_lineno)

    # Start and end

    def prepare(self, tcp: Vector, mass: float, center: Vector, start: Vector, tolerance: float) -> None:
        """Set tool, payload and tare, activate the gripper, and check that the arm is at the program's
        start posture."""
        self.at()
        for i, (is_, should) in enumerate(zip(self.receive.getActualQ(), start, strict=True)):
            if abs(is_ - should) > tolerance:
                raise Aborted(f"joint {i} is at {is_:.6f} rad, the program starts from {should:.6f} rad")
        self.done(self.control.setWatchdog(WATCHDOG), "setWatchdog")
        self.done(self.control.setTcp(list(tcp)), "setTcp")
        self.payload(mass, center)
        if self.can_zero:
            self.done(self.control.forceModeSetGainScaling(1.0), "forceModeSetGainScaling")
        self.activate_gripper()
        self.zero(settle=0.0)

    def activate_gripper(self) -> None:
        """Activate the Robotiq gripper, unless it is active already."""
        if self.gripper.get("STA") != 3:
            self.gripper.set("ACT", 1)
            if self.wait(lambda: self.gripper.get("STA") == 3, 10.0) > 10.0:
                raise Aborted("the gripper was not activated within 10 s")
        self.gripper.set("GTO", 1)

    def done(self, answer: bool, what: str) -> None:
        """Abort if a call of ur_rtde returned False, which means that the robot did not carry out the
        command."""
        if not answer:
            raise Aborted(f"the robot did not carry out {what}: protective stop, lost connection, or its script has ended")

    def there(self) -> bool:
        """Whether the robot still answers; if not, ur_rtde would wait for a command without end."""
        heard = time.monotonic() - self.seen[1] <= SILENT
        return heard and self.receive.isConnected() and self.control.isConnected()

    def listen(self) -> None:
        """Watch the connection, and end the program when the robot is silent for too long; calls of ur_rtde
        would wait forever."""
        last, heard = self.time(), time.monotonic()
        while not self.ended.wait(0.1):
            now = self.time()
            last, heard = (now, time.monotonic()) if now != last else (last, heard)
            if time.monotonic() - heard > SILENT + GONE:
                gone(f"nothing was heard from the robot for {SILENT + GONE:g} s")

    def rest(self) -> None:
        """Bring the robot to a safe state: no motion, no force mode."""
        self.control.stopL(3.0)
        self.control.forceModeStop()
        self.taken()

    def taken(self) -> None:
        """Wait until the controller has carried out a force-mode command; a command sent before that would replace it.

        The clock that this program sees is late when the program was kept waiting by its machine: only after it has
        slept do some cycles on that clock mean as many since the command.
        """
        time.sleep(ARRIVED)
        begin = self.time()
        for _ in range(round(SILENT / CYCLE)):
            if self.time() - begin >= TAKEN:
                return
            time.sleep(CYCLE)

    def close(self) -> None:
        """End ur_rtde's control script on the robot, which also stops the arm, and disconnect."""
        self.ended.set()
        self.control.stopScript()
        self.control.disconnect()

    # Motions

    def start(self, begin: Callable[[], bool]) -> None:
        """Start an asynchronous motion, and wait until the robot says that it has begun."""
        before = self.control.getAsyncOperationProgressEx().operationId()
        self.done(begin(), "the motion")
        if self.wait(lambda: self.control.getAsyncOperationProgressEx().operationId() != before, SILENT) > SILENT:
            raise Aborted("the motion did not begin")

    def moving(self) -> bool:
        """Whether the motion that was started still runs."""
        return bool(self.control.getAsyncOperationProgressEx().isAsyncOperationRunning())

    def follow(self, step: str, planned: float) -> None:
        """Wait until the running motion has ended; stop it if it takes too long."""
        timeout = SLOWER * planned + SILENT
        if self.wait(lambda: not self.moving(), timeout) > timeout:
            self.control.stopL(3.0)
            raise Failed(f"{step}: not done within {timeout:.1f} s")

    def move_joints(
        self, step: str, path: Sequence[Vector], *, speed: float, acceleration: float, radii: Vector = ()
    ) -> None:
        """Move through joint positions [rad]; ``radii`` are the blend radii of the TCP at each one but the last
        [m]."""
        self.at()
        if any(radii):
            blends = [*radii, 0.0]
            points = [[*q, speed, acceleration, r] for q, r in zip(path, blends, strict=True)]
            self.start(lambda: bool(self.control.moveJ(points, True)))
            self.follow(step, sum(math.tau / speed for _ in path))
            return
        here = list(self.receive.getActualQ())
        for goal in path:
            target = list(goal)
            self.start(lambda target=target: bool(self.control.moveJ(target, speed, acceleration, True)))  # type: ignore[misc]
            way = max(abs(a - b) for a, b in zip(here, target, strict=True))
            self.follow(step, way / speed + speed / acceleration)
            here = target

    def move_linear(self, step: str, target: Vector, *, speed: float, acceleration: float) -> None:
        """Move the TCP in a straight line to a pose."""
        self.at()
        way = math.dist(self.tcp()[:3], target[:3]) + 0.25 * math.pi
        self.start(lambda: bool(self.control.moveL(list(target), speed, acceleration, True)))
        self.follow(step, way / speed + speed / acceleration)

    def move_until_contact(
        self, step: str, direction: Vector, *, distance: float, speed: float, force: float, timeout: float, expect: str
    ) -> None:
        """Move along a direction of the base frame until the environment pushes back with a force [N]."""
        self.at()
        here, reaction = self.tcp(), 0.0
        target = [*(h + distance * d for h, d in zip(here[:3], direction, strict=True)), *here[3:]]
        self.start(lambda: bool(self.control.moveL(target, speed, GENTLE, True)))

        def touched() -> bool:
            nonlocal reaction
            reaction = -sum(f * d for f, d in zip(self.force(), direction, strict=True))
            return reaction > force or not self.moving()

        waited = self.wait(touched, timeout)
        self.control.stopL(3.0)
        if reaction > force:
            log(f"{step}: contact, {reaction:.3f} N")
        elif waited > timeout:
            raise Failed(f"{step}: no contact within {timeout:g} s")
        elif expect == "contact":
            raise Failed(f"{step}: no contact within {distance:g} m")

    # Gripper, payload, tare, time

    def grip(self, step: str, position: int, *, speed: int, force: int, expect: str, timeout: float) -> None:
        """Move the gripper's fingers to a position, with a speed and a force, all 0 .. 255.

        The register OBJ is trusted only after the register PRE has echoed the command.
        """
        self.at()
        hand = self.gripper
        for name, value in (("SPE", speed), ("FOR", force), ("POS", position)):
            hand.set(name, value)
        if self.wait(lambda: hand.get("PRE") == position and hand.get("OBJ") != 0, timeout) > timeout:
            raise Failed(f"{step}: the gripper still moved after {timeout:g} s")
        found = hand.get("OBJ") != 3
        if expect == "object" and not found:
            raise Failed(f"{step}: no object between the fingers")
        if expect == "none" and found:
            raise Failed(f"{step}: an object stopped the fingers")

    def payload(self, mass: float, center: Vector) -> None:
        """Tell the controller mass [kg] and centre of mass [m] of the load on the flange."""
        self.at()
        self.done(self.control.setPayload(mass, list(center)), "setPayload")

    def zero(self, settle: float = 0.3) -> None:
        """Tare the force sensor after a time in which the arm and the sensor's filter settle [s]."""
        self.stand_still(settle)
        if self.can_zero:
            self.done(self.control.zeroFtSensor(), "zeroFtSensor")
        else:
            self.tare = list(self.receive.getActualTCPForce()[:3])

    def stand_still(self, duration: float) -> None:
        """Wait for a duration [s]."""
        self.at()
        self.wait(lambda: False, duration)


def run_program(host: str, force_limit: float, steps: Callable[[Arm], None], *, zero: bool) -> int:
    """Run a program's steps on the robot at an address; however they end, the arm comes to rest.

    Returns:
        0 when all were carried out; else 1, and the log's last line says why.
    """
    arm, reason = None, ""
    try:
        arm = Arm(host, force_limit, zero=zero)
        steps(arm)
    except (Failed, Aborted, Tripped, OSError, RuntimeError) as error:
        reason = f"{error}" or type(error).__name__
    finally:
        if arm is not None and arm.there():
            with contextlib.suppress(RuntimeError):  # the connection is lost: the watchdog stops the robot
                arm.rest()
                arm.close()
    if arm is not None and reason and not arm.there():
        gone(reason)
    log(f"cramlite abort: {reason}" if reason else "cramlite: finished")
    return 1 if reason else 0
