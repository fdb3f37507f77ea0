"""Judges: processes that simulate the episodes of a benchmark, and the scenes of these episodes as scenarios."""
