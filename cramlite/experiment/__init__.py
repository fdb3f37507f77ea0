"""Experiments: many demonstrations, all candidates of each planned, proven and executed in twins, and their tables.

It knows no task: what is demonstrated, where, and when it has succeeded is said by files in ``experiments/``.
"""
