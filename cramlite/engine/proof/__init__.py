"""Proof of programs: their text runs on the controller model, and validators judge the run."""
