"""Imports of foreign descriptions: scenes and robots, from MJCF and URDF."""
