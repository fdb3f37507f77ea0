"""Plugin of event detection: contacts, support, grasps and contents of a rollout become the states of an episode."""

from __future__ import annotations

from cramlite.model import Episode, Rollout
from cramlite.plugin import hookimpl


@hookimpl
def detect_events(rollout: Rollout, name: str) -> Episode:
    """Detect the states of a rollout."""
    from .detect import detect

    return detect(rollout, name)
