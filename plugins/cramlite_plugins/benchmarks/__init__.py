"""Benchmarks: processes that simulate and judge their episodes, and the scenes of these episodes as scenarios."""
