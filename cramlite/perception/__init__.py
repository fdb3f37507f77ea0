"""Perception: a query about a view is answered by a pipeline of experts."""
