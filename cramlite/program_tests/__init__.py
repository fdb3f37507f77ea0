"""Tests of robot programs with pytest: programs run in worlds with contact, and assertions check the runs."""
