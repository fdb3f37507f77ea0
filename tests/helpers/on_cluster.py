"""What tests run on workers of a cluster, which import it by name."""

from __future__ import annotations

from cramlite.experiment.cluster_twins import ClusterRuns
from cramlite.model import Rollout, World
from cramlite.plugin.selection import INSTALLED


def run_in_twins(text: str, places: list[tuple[World, int]], most: int) -> tuple[list[Rollout | str], float]:
    """A task that runs a text in several worlds by further tasks, as a trial does; the first answers, and their CPU time."""
    group = ClusterRuns(INSTALLED)
    runs = group.runs(text, iter(places))
    return [next(runs) for _ in range(most)], group.seconds
