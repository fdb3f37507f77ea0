"""Imports of what others describe: scenes and robots, from MJCF and URDF."""
