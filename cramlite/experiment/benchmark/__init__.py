"""Experiments on benchmarks, whose episodes others define and judge.

A scene is planned and proven here, and the program is played in the benchmark's simulator.

An experiment file with the key ``benchmark`` is one of these. It names the Python file beside it that connects to the benchmark
(``protocol.Benchmark``), the suites of episodes, and what others have published about them.
"""
