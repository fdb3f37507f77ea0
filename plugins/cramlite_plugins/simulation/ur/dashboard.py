"""The dashboard server: text commands, one a line.

Source: Universal Robots, "Dashboard Server, e-Series": commands and their answers.
"""

from __future__ import annotations

from .virtual_robot import VirtualRobot

GREETING = "Connected: Universal Robots Dashboard Server"
VERSION = "URSoftware 5.12.0.1101319 (Mar 22 2022)"


def answer(line: str, robot: VirtualRobot) -> str:
    """Execute a dashboard command and return the answer."""
    words = line.strip()
    fixed = {
        "PolyscopeVersion": VERSION,
        "version": VERSION,
        "get serial number": "20225500000",
        "get robot model": robot.model_name,
        "power on": "Powering on",
        "power off": "Powering off",
        "brake release": "Brake releasing",
        "close popup": "closing popup",
        "close safety popup": "closing safety popup",
        "is in remote control": "true",
        "robotmode": "Robotmode: RUNNING",
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
            robot.unlock()
            return "Protective stop releasing"
        case "restart safety":
            robot.unlock()
            return "Restarting safety"
        case "quit":
            return "Disconnected"
    if words.startswith("popup "):
        robot.log(f"popup: {words.removeprefix('popup ')[:200]}")
        return "showing popup"
    return f"could not understand: '{words[:80]}'"
