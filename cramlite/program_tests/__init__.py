"""Tests of robot programs with pytest: programs run in worlds with contact; assertions are about their runs."""
