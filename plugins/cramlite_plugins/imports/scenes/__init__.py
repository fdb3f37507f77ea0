"""Scenes that other programs wrote: MJCF and URDF become things."""
