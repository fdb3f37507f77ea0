"""Experiments: many demonstrations, all candidates of each, planned, proven and executed in twins; the tables of that.

It knows no task: what is demonstrated, where, and when it has succeeded is said by files in ``experiments/``.
"""
