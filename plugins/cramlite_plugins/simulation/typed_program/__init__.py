"""Execution of typed programs on the controller model."""
