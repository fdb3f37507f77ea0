"""Recordings as tables of poses (CSV, JSON lines, motion capture), described by a mapping file."""
