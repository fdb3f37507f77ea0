"""Experiments in which others define and judge the episodes.

A scene is planned and proven here, and the program is played in the judge's simulator.

An experiment file with the key ``judge`` is one of these. It names the Python file beside it that answers for the judge
(``judge.Judge``), the suites of episodes, and what others have published about them.
"""
