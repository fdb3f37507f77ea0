"""Import of MuJoCo without its libraries for windows, such as GLFW, which are imported when a window is opened."""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import Any


class _Later(ModuleType):
    """Stand-in for a module that is imported when an attribute of it is first used."""

    def __getattr__(self, name: str) -> Any:
        return getattr(importlib.import_module(self.__name__), name)


def import_mujoco() -> None:
    """Import MuJoCo; GLFW only when a window or an OpenGL context is asked for.

    ``import mujoco`` imports GLFW, whose bindings parse C declarations: a quarter of its CPU time. Whoever opens a
    ``mujoco.Renderer`` in this process still can.
    """
    if "mujoco" in sys.modules or "glfw" in sys.modules:
        return
    later = sys.modules["glfw"] = _Later("glfw")
    try:
        importlib.import_module("mujoco")
    finally:
        if sys.modules.get("glfw") is later:
            del sys.modules["glfw"]
