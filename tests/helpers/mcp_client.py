"""Calls to ``cramlite mcp`` by the official client, and a server with a run that it proved."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import anyio
from mcp import Client, MCPError

from cramlite import Engine
from cramlite.cli.serving.client_files import ClientFiles
from cramlite.cli.serving.mcp_server import Server, make_server

SCENARIO = Path(__file__).parents[2] / "scenarios" / "grasp_one_thing.yaml"
TABLE = """
scenario: table
designator: {task: Grasping, Patient: tin}
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: box, model: table, type: soma:Table, at: {position: [0.5, -0.25, 45 mm]}, with: {size: [200 mm, 200 mm, 80 mm]}}
  - {name: tin, model: block, type: cram:Tin, at: {position: [0.4, 0.3, 30 mm]}}
"""


def told(result: Any) -> str:
    return " ".join(c.text for c in result.content if c.type == "text")


def ask(server: object, use: Callable[[Client], Awaitable[Any]], mode: str = "auto") -> Any:
    async def session() -> Any:
        async with Client(server, mode=mode) as client:  # type: ignore[arg-type]
            return await use(client)

    return anyio.run(session)


def call(server: object, tool: str, **arguments: Any) -> Any:
    return ask(server, lambda client: client.call_tool(tool, arguments))


def unread(server: object, uri: str) -> str:
    """Return the server's error message for a resource that it cannot or must not read."""

    async def read(client: Client) -> str:
        try:
            return f"READ: {await client.read_resource(uri)}"
        except MCPError as error:
            return str(error)

    said = str(ask(server, read))
    assert not said.startswith("READ"), said[:200]
    return said


class Proven:
    """MCP server in this process, with a run that it proved without twins."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.scenario = folder / "mine.yaml"
        self.scenario.write_text(SCENARIO.read_text().replace("scenario: grasp_one_thing", "scenario: mine"))
        self.server: Server = make_server(Engine(), ClientFiles(folder, folder / "runs"))
        self.run = self.resolve()
        self.place = folder / "runs" / self.run

    def resolve(self) -> str:
        return str(call(self.server, "resolve", scenario="mine.yaml").structured_content["run"])

    def refused(self, tool: str, **arguments: Any) -> str:
        """Return the server's objection to a tool call, and check that the call executed nothing."""
        before = self.executed
        answer = call(self.server, tool, **arguments)
        assert answer.is_error, told(answer)
        assert self.executed == before, "something moved"
        return told(answer)

    @property
    def executed(self) -> dict[str, int]:
        return {str(p): p.stat().st_mtime_ns for p in (self.folder / "runs").rglob("execution.json")}
