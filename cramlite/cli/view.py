"""``cramlite view``: shows a run in an interactive 3D viewer in the browser."""

from __future__ import annotations

import argparse
import errno
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import UserError
from ..model.run.rollout import Rollout
from ..plugin.catalogue import Knowledge
from .arguments import Add, duration, plugin_choice
from .program_input import in_its_world, program_of, recorded

if TYPE_CHECKING:
    from .viewer import Viewer


RATE = 25.0
"""Number of positions of the time slider per second: as many as viser plays smoothly."""


def _view(arguments: argparse.Namespace) -> int:
    """Serve a run to the browser until the time is up or the person interrupts.

    Raises:
        UserError: the extra is not installed, the folder holds no run, or the address cannot be used.
    """
    require_viser()
    run = arguments.directory
    knowledge = Knowledge(plugin_choice(arguments).registry())
    rollout = recorded(run, arguments.world, knowledge, arguments.seed)
    viewer = viewer_of(rollout, knowledge, program_of(run), arguments.host, arguments.port)
    print(f"{run}: {rollout.times[-1]:.1f} s, {rollout.outcome}. The viewer is at {viewer.url}", flush=True)
    if not arguments.no_browser and not open_browser(viewer.url):
        print(no_browser(viewer.url), file=sys.stderr, flush=True)
    try:
        viewer.play(arguments.seconds)
    except KeyboardInterrupt:
        pass
    finally:
        viewer.close()
    return 0


def require_viser() -> None:
    """Check that the extra with viser is installed."""
    from importlib.util import find_spec

    if find_spec("viser") is None:
        raise UserError(
            "'cramlite view' needs the package viser, which is not installed: pip install 'cramlite[view]' (4 MB). Without it, "
            "open the run's report.html in a browser: it has a drawing of the run that can be turned, with a time slider."
        )


def viewer_of(rollout: Rollout, knowledge: Knowledge, program: Sequence[str], host: str, port: int) -> Viewer:
    """Start the web server of a 3D viewer that shows a run, and return the viewer.

    Args:
        program: the text's lines; none if it is not known.

    Raises:
        UserError: the run does not belong to its world, or nothing can be served there.
    """
    import numpy as np

    from .viewer import Viewer

    step = 1 / RATE
    times = np.arange(rollout.times[0], rollout.times[-1] + step / 2, step)
    samples = np.searchsorted(rollout.times, times).clip(0, len(rollout.times) - 1)
    shown = [int(k) for k in samples]
    with in_its_world():
        scene = knowledge.simulator.scene(rollout, knowledge.robots_of(rollout.world), shown)
    return Viewer(scene, rollout, shown, program, host, free_port(host, port))


def free_port(host: str, first: int, tries: int = 100) -> int:
    """Find the first port, from ``first`` on, that nobody listens at.

    It is asked beforehand: viser would wait for an address of another computer for ever.

    Raises:
        UserError: none of these, or no address of this computer.
    """
    import socket

    why: object = "no port is free"
    for port in range(first, min(first + tries, 65536)):
        try:
            with socket.create_server((host, port)):
                return port
        except OSError as error:
            why = error
            if error.errno != errno.EADDRINUSE:
                break
    raise UserError(f"Nothing can be served at {host}:{first} ({why}); choose --host and --port.")


def open_browser(url: str) -> bool:
    """Open a browser at an address; return whether one could be opened.

    One in a terminal is not opened: it shows no 3D.
    """
    import webbrowser

    graphical = sys.platform in ("win32", "darwin") or any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    )
    try:
        return graphical and webbrowser.open(url)
    except webbrowser.Error:
        return False


def no_browser(url: str) -> str:
    """Return text for a person without a browser on this computer: how to open the viewer's address elsewhere."""
    port = url.rstrip("/").rpartition(":")[2]
    return (
        f"No browser could be opened here. Open {url} yourself; from another computer, after 'ssh -L {port}:localhost:{port} "
        "HOST', open the same address there. With --no-browser none is opened; Ctrl+C ends the viewer."
    )


def add_commands(add: Add) -> None:
    """Add the command ``view``, with its arguments, to the command line."""
    view = add("view", _view)
    view.add_argument("directory", type=Path, metavar="RUN", help="a folder of 'resolve --out' or 'execute --out'")
    view.add_argument("--world", help="a run directory, its world.json, or a scenario, where RUN holds no world; default RUN/world.json")
    view.add_argument("--seed", type=int, default=0, help="seed of a scenario's world; default 0")
    view.add_argument("--host", default="127.0.0.1", help="address to serve at; default 127.0.0.1")
    view.add_argument("--port", type=int, default=8080, help="the first port to try; default 8080")
    view.add_argument("--no-browser", action="store_true", help="print the address and open no browser")
    view.add_argument(
        "--seconds", type=duration, default=0.0,
        help="close after this time; 0 (default) for no limit, Ctrl+C ends it",
    )
