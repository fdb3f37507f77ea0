"""Event detection as a plugin: contacts, support, grasps and contents of a rollout become the states of an episode."""

from __future__ import annotations

from cramlite.model import Episode, Rollout
from cramlite.plugin import hookimpl


@hookimpl
def detect_events(rollout: Rollout, name: str) -> Episode:
    from .detect import detect

    return detect(rollout, name)
