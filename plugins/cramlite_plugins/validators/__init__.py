"""Validators: checks of a candidate program before its text is written, and of the run of that text."""
