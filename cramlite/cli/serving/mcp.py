"""``cramlite mcp``: an MCP server on standard input and output, or on loopback over HTTP."""

from __future__ import annotations

import argparse
import os
import socket
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.errors import UserError
from ...plugin.selection import INSTALLED, PluginChoice
from ..arguments import Add, plugin_choice

if TYPE_CHECKING:
    from .mcp_server import Server

LOOPBACK = "127.0.0.1"
LONGEST_BODY = 1_000_000
"""Largest size of a request over HTTP [bytes]: calls take some hundred."""


def serve_mcp(*, folder: Path, runs: Path | None = None, port: int | None = None, plugins: PluginChoice = INSTALLED) -> int:
    """Run the MCP server until the client disconnects or, over HTTP, until the person interrupts it.

    Args:
        folder: whose scenarios and episodes clients may name.
        runs: where the runs go; by default ``folder/runs``.
        port: of loopback to serve at over HTTP, 0 for any that is free; None for standard input and output.

    Raises:
        UserError: the extra is not installed, there is no such folder, the runs cannot go where they should, or the port is taken.
    """
    if find_spec("mcp") is None:
        raise UserError("'cramlite mcp' needs the package mcp, which is not installed: pip install 'cramlite[mcp]'.")
    if not folder.is_dir():
        raise UserError(f"There is no folder '{folder}'; give one with --folder, from which clients may name scenarios and episodes.")
    runs = runs or folder / "runs"
    there = next(p for p in (runs.resolve(), *runs.resolve().parents) if p.exists())
    if not there.is_dir():
        raise UserError(f"The runs cannot go to '{runs}': '{there}' is no folder; give another one with --runs.")
    listening = None if port is None else _listen(port)
    import anyio

    from ...engine.engine import Engine
    from .client_files import ClientFiles
    from .mcp_server import make_server

    server = make_server(Engine.with_plugins(plugins), ClientFiles(folder.resolve(), runs.resolve()))
    if listening is None:
        anyio.run(server.run_stdio_async)
    else:
        with listening:
            anyio.run(_serve_http, server, listening)
    return 0


def _listen(port: int) -> socket.socket:
    """Open a loopback socket that listens at the port, so that a port in use is reported before plugins are loaded."""
    try:
        return socket.create_server((LOOPBACK, port))
    except (OSError, OverflowError) as error:
        why = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else error
        raise UserError(f"Nothing can be served at {LOOPBACK}:{port} ({why}); give another --http PORT, or 0 for any.") from error


async def _serve_http(server: Server, listening: socket.socket) -> None:
    import uvicorn

    port = listening.getsockname()[1]
    app = server.streamable_http_app(host=LOOPBACK, max_request_body_size=LONGEST_BODY)
    print(f"Listening at http://{LOOPBACK}:{port}/mcp", file=sys.stderr, flush=True)
    await uvicorn.Server(uvicorn.Config(app, log_level="warning")).serve(sockets=[listening])


def _mcp(arguments: argparse.Namespace) -> int:
    return serve_mcp(folder=arguments.folder, runs=arguments.runs, port=arguments.http, plugins=plugin_choice(arguments))


def add_commands(add: Add) -> None:
    """Add the command ``mcp``, with its arguments, to the command line."""
    mcp = add("mcp", _mcp)
    mcp.add_argument(
        "--folder", type=Path, default=Path(),
        help="clients may name its scenarios and episodes; default the current folder",
    )
    mcp.add_argument("--runs", type=Path, metavar="DIR", help="where the runs go; default runs in the folder")
    mcp.add_argument("--http", type=int, metavar="PORT", help="serve over HTTP on loopback, 0 for any free port; default: stdin and stdout")
