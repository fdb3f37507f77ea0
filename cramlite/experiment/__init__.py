"""Experiments: many trials, each planned, proven and executed, and tables of their results.

One harness serves two kinds of trials: demonstrations that we record and judge (``demonstrations``), and episodes of benchmarks, which
others defined and judge (``benchmark``). It knows no task: what is demonstrated or played, where, and when it has succeeded is said by
files in ``experiments/``.
"""
