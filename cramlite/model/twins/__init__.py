"""Twins of the believed world: sources of error, their sizes, and how values are drawn."""
