"""The dashboard server: text commands, one a line.

Source: Universal Robots, "Dashboard Server, e-Series": commands and their answers.
"""

from __future__ import annotations

from .virtual_robot import IDLE, POWER_OFF, RUNNING, VirtualRobot

GREETING = "Connected: Universal Robots Dashboard Server"
TOO_EARLY = (
    "Cannot unlock protective stop until 5s after occurrence. Always inspect cause of protective stop before unlocking"
)
MODES = {POWER_OFF: "POWER_OFF", IDLE: "IDLE", RUNNING: "RUNNING"}
VERSION = "URSoftware 5.12.0.1101319 (Mar 22 2022)"


def answer(line: str, robot: VirtualRobot) -> str:
    """Execute a dashboard command and return the answer."""
    words = line.strip()
    fixed = {
        "PolyscopeVersion": VERSION,
        "version": VERSION,
        "get serial number": "20225500000",
        "get robot model": robot.model_name,
        "close popup": "closing popup",
        "close safety popup": "closing safety popup",
        "is in remote control": "true",
        "get operational mode": "AUTOMATIC",
        "get loaded program": "No program loaded",
        "isProgramSaved": "false",
    }
    if words in fixed:
        return fixed[words]
    match words:
        case "stop":
            robot.stop_program("stopped at the dashboard")
            return "Stopped"
        case "running":
            return f"Program running: {str(robot.running).lower()}"
        case "programState":
            return ("PLAYING" if robot.running else "STOPPED") + " <unnamed>"
        case "safetystatus":
            return f"Safetystatus: {robot.safety_status}"
        case "safetymode":
            return f"Safetymode: {robot.safety_status}"
        case "unlock protective stop":
            return "Protective stop releasing" if robot.unlock() else TOO_EARLY
        case "restart safety":
            robot.restart()
            return "Restarting safety"
        case "robotmode":
            return f"Robotmode: {MODES[robot.mode]}"
        case "power on":
            robot.power(IDLE)
            return "Powering on"
        case "power off":
            robot.power(POWER_OFF)
            return "Powering off"
        case "brake release":
            robot.power(RUNNING)
            return "Brake releasing"
        case "play":
            return "Failed to execute: play"
        case "quit":
            return "Disconnected"
    if words.startswith("load "):
        return f"File not found: {words.removeprefix('load ')[:200]}"
    if words.startswith("popup "):
        robot.log(f"popup: {words.removeprefix('popup ')[:200]}")
        return "showing popup"
    return f"could not understand: '{words[:80]}'"
