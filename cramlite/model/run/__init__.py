"""Runs of programs: records, peaks, sensor readings, limits and verdicts."""
