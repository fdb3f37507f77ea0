"""Old name of `cramlite_plugins.imports.robots.robot_file`: it stands for the same module, and warns."""

import sys
import warnings
from importlib import import_module

NEW = "cramlite_plugins.imports.robots.robot_file"
warnings.warn(f"{__name__} is now {NEW}: write this name in its place", DeprecationWarning, stacklevel=2)
sys.modules[__name__] = import_module(NEW)
