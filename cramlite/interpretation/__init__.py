"""Interpretation: an episode becomes the tasks that it may show, by rules over a timeline."""
