"""Base classes and preconditions of task types."""
