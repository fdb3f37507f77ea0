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
    """The first program of a shipped scenario, which every validator passes."""
    candidate, verdict, reasons = attempted(name, folder)
    assert candidate is not None and verdict is not None and verdict.passed, reasons
    return candidate


def without(candidate: Candidate, *origins: str) -> str:
    """The text without the code of some steps; every other line keeps its number."""
    code = candidate.code
    assert code is not None
    lines, starts = code.text.splitlines(), sorted(code.origins)
    for start, end in zip(starts, [*starts[1:], starts[-1] + 1], strict=True):
        if any(code.origins[start] == o or code.origins[start].startswith(f"{o}/") for o in origins):
            for k in range(start - 1, end - 1):
                lines[k] = lines[k] if lines[k].lstrip().startswith("#") else GONE
    return "\n".join(lines)


def replaced(candidate: Candidate, *changes: tuple[str, str]) -> str:
    """The text with words replaced, each of which is there."""
    assert candidate.code is not None
    text = candidate.code.text
    for old, new in changes:
        assert old in text, f"'{old}' is not in the program"
        text = text.replace(old, new)
    return text


def run(candidate: Candidate, text: str, world: World | None = None) -> Candidate:
    """The candidate with another text, and what happened when that ran, in its own world or another."""
    knowledge = engine().knowledge
    assert candidate.code is not None
    place = world or candidate.world
    rollout = knowledge.simulator.execute(text, place, knowledge.robots, mount=candidate.program.robot, seed=0)
    episode = knowledge.episodes.detect(rollout, candidate.program.name)
    episode = replace(episode, extras={**episode.extras, "park": np.array(candidate.robot.home)})
    code = replace(candidate.code, text=text, origins=dict(origins_of(text, candidate.code).of))
    return replace(candidate, code=code, proven=candidate.code, rollout=rollout, episode=episode, world=place)


def objections(candidate: Candidate) -> dict[str, str]:
    """Validator -> the first of its reasons against a candidate that ran."""
    found: dict[str, str] = {}
    for finding in findings(candidate):
        if not finding.passed:
            found.setdefault(finding.validator, finding.reason)
    return found


def findings(candidate: Candidate) -> list[Finding]:
    return findings_of(candidate, engine().knowledge, rollout=True)


def against(candidate: Candidate, text: str, world: World | None = None) -> dict[str, str]:
    """Why a text is refused where a candidate's was proven: validator -> reason; empty where it is not."""
    return objections(run(candidate, text, world))
