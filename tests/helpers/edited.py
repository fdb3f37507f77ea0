"""Proven programs whose text is edited, as a hand would, and judged again."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from cramlite.engine.proof.line_origins import origins_of
from cramlite.engine.proof.proof import findings_of
from cramlite.model import Finding, World
from cramlite.plugin import Candidate
from helpers.task_scenarios import attempted, engine

GONE = "# taken out"


def proven(name: str, folder: str = "tasks") -> Candidate:
    """Return the first candidate of a shipped scenario, and check that every validator passes it."""
    candidate, verdict, reasons = attempted(name, folder)
    assert candidate is not None and verdict is not None and verdict.passed, reasons
    return candidate


def without(candidate: Candidate, *origins: str) -> str:
    """Return the program's text without the code of some steps; every other line keeps its number."""
    code = candidate.code
    assert code is not None
    lines, starts = code.text.splitlines(), sorted(code.origins)
    for start, end in zip(starts, [*starts[1:], starts[-1] + 1], strict=True):
        if any(code.origins[start] == o or code.origins[start].startswith(f"{o}/") for o in origins):
            for k in range(start - 1, end - 1):
                lines[k] = lines[k] if lines[k].lstrip().startswith("#") else GONE
    return "\n".join(lines)


def replaced(candidate: Candidate, *changes: tuple[str, str]) -> str:
    """Return the program's text with words replaced; each word must occur in it."""
    assert candidate.code is not None
    text = candidate.code.text
    for old, new in changes:
        assert old in text, f"'{old}' is not in the program"
        text = text.replace(old, new)
    return text


def run(candidate: Candidate, text: str, world: World | None = None) -> Candidate:
    """Run another text in a candidate's world or in a given one, and return the candidate with that text, rollout and episode."""
    knowledge = engine().knowledge
    assert candidate.code is not None
    place = world or candidate.world
    rollout = knowledge.simulator.execute(text, place, knowledge.robots, mount=candidate.program.robot, seed=0)
    episode = knowledge.episodes.detect(rollout, candidate.program.name)
    episode = replace(episode, extras={**episode.extras, "park": np.array(candidate.robot.home)})
    code = replace(candidate.code, text=text, origins=dict(origins_of(text, candidate.code).of))
    return replace(candidate, code=code, proven=candidate.code, rollout=rollout, episode=episode, world=place)


def objections(candidate: Candidate) -> dict[str, str]:
    """Return for each validator that objects to a candidate's run its first reason."""
    found: dict[str, str] = {}
    for finding in findings(candidate):
        if not finding.passed:
            found.setdefault(finding.validator, finding.reason)
    return found


def findings(candidate: Candidate) -> list[Finding]:
    return findings_of(candidate, engine().knowledge, rollout=True)


def against(candidate: Candidate, text: str, world: World | None = None) -> dict[str, str]:
    """Run an edited text of a proven candidate, and return each validator's first objection to it; empty if none objects."""
    return objections(run(candidate, text, world))
