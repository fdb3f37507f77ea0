"""Scenes from MJCF and URDF files, as things of cramlite."""
