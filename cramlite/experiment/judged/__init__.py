"""Experiments whose episodes others define and judge: a scene is planned and proven here, and played in
the judge's simulator.

An experiment file with the key ``judge`` is one of these. It names the Python file beside it that answers for the judge
(``judge.Judge``), the suites of episodes, and what others have published about them.
"""
