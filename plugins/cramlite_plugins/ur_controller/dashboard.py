"""The dashboard server: text commands, one a line.

Source: Universal Robots, "Dashboard Server, e-Series": commands and their answers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from .virtual_robot import IDLE, POWER_OFF, RUNNING, VirtualRobot

GREETING = "Connected: Universal Robots Dashboard Server"
TOO_EARLY = (
    "Cannot unlock protective stop until 5s after occurrence. Always inspect cause of protective stop before unlocking"
)
MODES = {POWER_OFF: "POWER_OFF", IDLE: "IDLE", RUNNING: "RUNNING"}
VERSION = "URSoftware 5.12.0.1101319 (Mar 22 2022)"


FIXED: Mapping[str, str] = {
    "PolyscopeVersion": VERSION,
    "version": VERSION,
    "get serial number": "20225500000",
    "close popup": "closing popup",
    "close safety popup": "closing safety popup",
    "is in remote control": "true",
    "get operational mode": "AUTOMATIC",
    "get loaded program": "No program loaded",
    "isProgramSaved": "false",
    "play": "Failed to execute: play",
    "quit": "Disconnected",
}
"""Dashboard commands with their constant answers."""
STATES: Mapping[str, Callable[[VirtualRobot], str]] = {
    "get robot model": lambda r: r.model_name,
    "running": lambda r: f"Program running: {str(r.running).lower()}",
    "programState": lambda r: ("PLAYING" if r.running else "STOPPED") + " <unnamed>",
    "safetystatus": lambda r: f"Safetystatus: {r.safety_status}",
    "safetymode": lambda r: f"Safetymode: {r.safety_status}",
    "robotmode": lambda r: f"Robotmode: {MODES[r.mode]}",
}
"""Dashboard commands that ask for a state of the robot, with functions that return the answer."""


def answer(line: str, robot: VirtualRobot) -> str:
    """Execute a dashboard command and return the answer."""
    words = line.strip()
    if words in FIXED:
        return FIXED[words]
    if words in STATES:
        return STATES[words](robot)
    match words:
        case "stop":
            robot.stop_program("stopped at the dashboard")
            return "Stopped"
        case "unlock protective stop":
            return "Protective stop releasing" if robot.unlock() else TOO_EARLY
        case "restart safety":
            robot.restart()
            return "Restarting safety"
        case "power on":
            robot.power(IDLE)
            return "Powering on"
        case "power off":
            robot.power(POWER_OFF)
            return "Powering off"
        case "brake release":
            robot.power(RUNNING)
            return "Brake releasing"
    if words.startswith("load "):
        return f"File not found: {words.removeprefix('load ')[:200]}"
    if words.startswith("popup "):
        robot.log(f"popup: {words.removeprefix('popup ')[:200]}")
        return "showing popup"
    return f"could not understand: '{words[:80]}'"
