"""Interpretation of episodes: recognition of the tasks that each action may be, by rules over a timeline."""
