"""First PolyScope version of each URScript function on each Universal Robots controller; checks of programs against
these versions.

Sources: [script] the version marks of ur_rtde 1.6.5's control script inside its wheel ("$5.10|3.15 ..." keeps a line for these
versions and later); [client] UniversalRobots' ur_client_library, "Script Command Interface" and "Force Mode example" (no gain
scaling on CB3); [external] the same library's external_control.urscript (commit 0046867), which runs on PolyScope X from 10.7.0 on
and calls these functions there, direct_torque from 10.11.0 on: what it calls without a condition is there by 10.7, perhaps before;
[facts] the project's own notes (reference/robot_code.md). Nothing here has run on PolyScope X; "?" is what no source that was read says.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from cramlite.model import Program, Robot, Value
from cramlite.plugin import UserError, nearest

CB3, E_SERIES, X = "CB3", "e-Series", "PolyScope X"


class Capability(Value):
    """A URScript function and its first PolyScope version on each controller: "" if it never had it, "?" if unknown."""

    function: str
    cb3: str
    e_series: str
    polyscope_x: str
    source: str

    def since(self, controller: str) -> str:
        """Return the first PolyScope version of a controller that has the function."""
        return {CB3: self.cb3, E_SERIES: self.e_series, X: self.polyscope_x}[controller]


CAPABILITIES = (
    Capability("force_mode", "3.5", "5.0", "10.7", "[script] unmarked; damping from 3.5; [external]"),
    Capability("force_mode_set_damping", "3.5", "5.0", "10.7", "[script]; [external]"),
    Capability("force_mode_set_gain_scaling", "", "5.0", "10.7", "[script] [client]; [external]"),
    Capability("zero_ftsensor", "", "5.0", "10.7", "[facts]; [script] unmarked; [external]"),
    Capability("set_target_payload", "", "5.10", "?", "[script]"),
    Capability("get_inverse_kin_has_solution", "3.15", "5.10", "?", "[script]"),
    Capability("tool_contact", "", "5.4", "10.7", "[script]; [external]"),
    Capability("get_actual_joint_positions_history", "", "5.4", "10.7", "[script]; [external]"),
    Capability("get_target_waypoint", "", "5.3", "?", "[script]"),
    Capability("get_tcp_offset", "3.6", "5.0", "?", "[script]"),
    Capability("protective_stop", "3.8", "5.0", "?", "[script]"),
    Capability("ft_rtde_input_enable", "3.14", "5.9", "10.7", "[script]; [external], CB3 too"),
    Capability("freedrive_mode", "3.15", "5.10", "10.7", "[script] with free axes from 5.10; [external]"),
    Capability("direct_torque", "", "5.26", "10.11", "[script]; [external], which says 5.23"),
)
NEEDED = {CB3: "3.15", E_SERIES: "5.11"}
"""The controllers that programs are written for, and the PolyScope version that they ask for in their header."""


def controller_of(robot: Robot) -> tuple[str, str]:
    """Return the controller that an arm declares, and the PolyScope version that its programs need.

    Raises:
        UserError: it declares none, one that programs are not written for, or what a CB3 cannot have.
    """
    if robot.controller not in NEEDED:
        what = f"its controller as '{robot.controller}'" if robot.controller else "no controller"
        raise UserError(f"robot '{robot.type}' declares {what} ('controller' of the Robot); {nearest(robot.controller, NEEDED)}")
    if robot.controller == CB3 and robot.sensor == "flange":
        said = f"robot '{robot.type}' declares a CB3 with a force sensor in the flange, which only e-Series have"
        raise UserError(f"{said}; correct 'controller' or 'sensor'")
    return robot.controller, NEEDED[robot.controller]


def check_arm(program: Program, robot: Robot, language: str) -> None:
    """Check that the program is for this arm, and that the arm's axes have their zeros where those of
    Universal Robots have them.

    Raises:
        UserError: it is not.
    """
    if program.robot_type != robot.type or robot.backend != "urscript":
        raise UserError(f"program for '{program.robot_type}': {language} for '{robot.type}' cannot carry it out")
    if any(robot.axis_zeros or ()):
        raise UserError(
            f"robot '{robot.type}' declares axes that are not zero where its Denavit-Hartenberg table is ({robot.axis_zeros} rad); "
            f"{language} is written for arms of Universal Robots, whose axes are"
        )


def lacking(text: str, controller: str, version: str) -> Iterator[str]:
    """List, in words, the functions that a program calls and a controller of this version lacks."""
    code = "\n".join(line.split("#")[0] for line in text.split("\n"))
    for c in CAPABILITIES:
        if re.search(rf"\b{c.function}\(", code):
            since = c.since(controller)
            if since in ("", "?"):
                known = "is not known to have" if since == "?" else "does not have"
                yield f"{controller} {known} {c.function} ({c.source})"
            elif _number(version) < _number(since):
                yield f"{c.function} needs PolyScope {since} on {controller}, not {version} ({c.source})"


def _number(version: str) -> tuple[int, ...]:
    return tuple(int(v) for v in version.split("."))


PRELUDE = """
# ---- CB3 ----
# There is no zero_ftsensor here: the tare is kept by the program (base frame).
global tare = [0.0, 0.0, 0.0]
def net_force():
  local measured = get_tcp_force()
  return [measured[0] - tare[0], measured[1] - tare[1], measured[2] - tare[2]]
end
def zero_sensor():
  local measured = get_tcp_force()
  tare = [measured[0], measured[1], measured[2]]
end
"""


CALLS = {
    r"\bzero_ftsensor\(": "zero_sensor(",
    r"\bget_tcp_force\(\)": "net_force()",
    r"\bforce\(\)": "norm(net_force())",
    r"\bset_target_payload\(": "set_payload(",
}


def adapted(lines: list[str]) -> list[str]:
    """Replace e-Series calls by those of CB3, line by line, so that line numbers stay."""
    for old, new in CALLS.items():
        lines = [re.sub(old, new, line) for line in lines]
    return lines
