"""Perception: a camera, and experts that answer queries from what it saw."""
