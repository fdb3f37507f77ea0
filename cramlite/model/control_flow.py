"""Plan language: control structures over designators. See docs/reference/plan_language.md.

A ``Compound`` is an action that is made of others. Two of its kinds are decided while planning: "sequence", and
"choose", whose branches are alternatives of the search. The others are decided while the program runs: they become
control steps of the program (``cramlite.model.program.steps``), and text; "fallback" is what behaviour trees call so.

    >>> from cramlite.model import Motion
    >>> search = Motion("1.Search/spiral", "spiral_search", parameters={"radius_m": 0.003})
    >>> retry("1.Search/retry", search, {"radius_m": 0.008}).branches[1][0].parameters
    {'radius_m': 0.008}
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal

from msgspec.structs import replace

from ..base.value import Value
from .designator_name import part_name
from .designators import Action, Designator, Motion

Kind = Literal["sequence", "choose", "fallback", "parallel", "try_all", "repeat", "monitor"]
Branch = tuple[Designator, ...]


class Compound(Action):
    """Control structure over designators; made by the functions below.

    Args:
        kind: the rule; ``task`` is the same as a class.
        branches: each is done in order; sequence, repeat and monitor have one.
        parameters: "times" of repeat; "force_n", "slip_m" and "time_s" of monitor, those that are watched.
    """

    kind: Kind = "sequence"
    branches: tuple[Branch, ...] = ()

    def __str__(self) -> str:
        inner = " | ".join(", ".join(p.name for p in b) for b in self.branches)
        return f"{self.kind}({inner})"

    @property
    def decided_at_run_time(self) -> bool:
        """Whether this control structure becomes a control step of the program, instead of being decided
        while planning."""
        return self.kind not in ("sequence", "choose")


class Mark(Value):
    """Marker on the search's agenda at which a branch of a control structure begins.

    The marker after the last branch is the end of the control structure.
    """

    compound: Compound
    branch: int


def compound(kind: Kind, name: str, branches: tuple[Branch, ...], **parameters: float) -> Compound:
    """Construct a control structure of any kind; its branches must not be empty."""
    if not branches or not all(branches):
        raise ValueError(f"{kind} '{name}' needs something to do")
    return Compound(name, f"cram:{kind}", parameters=parameters, kind=kind, branches=branches)


def sequence(name: str, *parts: Designator) -> Compound:
    """Construct a sequence: one part after the other; the first failure ends it."""
    return compound("sequence", name, (parts,))


def choose(name: str, *parts: Designator) -> Compound:
    """Construct a choice among alternatives that is made while planning.

    The program holds only the first part that can be resolved, and whose program is proven.
    """
    return compound("choose", name, tuple((p,) for p in parts))


def fallback(name: str, *parts: Designator) -> Compound:
    """Construct a fallback that is decided while the program runs: one part after the other, until one succeeds.

    The program holds all of them.
    """
    return compound("fallback", name, tuple((p,) for p in parts))


def retry(name: str, part: Action | Motion, *changes: Mapping[str, Any]) -> Compound:
    """Construct repeated attempts at an action or motion: first as it is, then with each change of its parameters, until one succeeds."""
    again = [
        replace(part, name=part_name(part.name, f"attempt_{k}"), parameters={**part.parameters, **change})
        for k, change in enumerate(changes, 2)
    ]
    return fallback(name, part, *again)


def parallel(name: str, *parts: Designator) -> Compound:
    """Construct parallel execution: it succeeds when all parts have; the first failure stops the others."""
    return compound("parallel", name, tuple((p,) for p in parts))


def try_all(name: str, *parts: Designator) -> Compound:
    """Construct a parallel race: the first success stops the others; it fails when all parts have.

    The arm then goes back to where it began, because only the run decides which part succeeds.
    """
    return compound("try_all", name, tuple((p,) for p in parts))


def repeat(name: str, times: int, *parts: Designator) -> Compound:
    """Construct a loop of ``times`` passes; the first failure ends it.

    After a pass that ends at another pose, the arm moves back to where the pass began.
    """
    return compound("repeat", name, (parts,), times=times)


def monitor(
    name: str,
    *parts: Designator,
    force_n: float | None = None,
    slip_m: float | None = None,
    time_s: float | None = None,
) -> Compound:
    """Construct monitored execution: the parts are stopped, and it fails, when a watched quantity exceeds its limit.

    Watched are the force on the tool [N], how far the fingers close further [m], and the time [s]; those that are
    given.

    Raises:
        ValueError: nothing is watched.
    """
    watched = {k: v for k, v in (("force_n", force_n), ("slip_m", slip_m), ("time_s", time_s)) if v is not None}
    if not watched:
        raise ValueError(f"monitor '{name}' watches nothing: give force_n, slip_m or time_s")
    return compound("monitor", name, (parts,), **watched)


class Way(Value):
    """One way to resolve a control structure in the search: the items that replace it on the agenda, with
    reason and cost."""

    steps: tuple[Designator | Mark, ...]
    reason: str
    cost: float = 0.0


def ways(item: Compound) -> Iterator[Way]:
    """Yield the ways to resolve a control structure in the search: each alternative of a choice, else all
    branches together.

    A ``Mark`` before each branch, and one after the last, separate the branches.
    """
    if item.kind == "sequence":
        yield Way(item.branches[0], "in this order")
    elif item.kind == "choose":
        for k, branch in enumerate(item.branches):
            names = ", ".join(p.name for p in branch)
            steps = (Mark(item, 0), *branch, Mark(item, len(item.branches)))
            yield Way(steps, f"alternative {k + 1} of {len(item.branches)}: {names}", float(k))
    else:
        marked: list[Designator | Mark] = [
            part for k, branch in enumerate(item.branches) for part in (Mark(item, k), *branch)
        ]
        yield Way((*marked, Mark(item, len(item.branches))), f"{item.kind}, decided while the program runs")


def touched(item: Compound) -> tuple[str, ...]:
    """Return the names of the objects that tasks and motions inside a control structure may touch."""
    found: list[str] = []
    for part in (p for branch in item.branches for p in branch):
        if isinstance(part, Compound):
            found += touched(part)
        elif isinstance(part, Action):
            found += (o.name for o in part.roles.values())
        elif isinstance(part, Motion):
            found += part.may_touch
    return tuple(dict.fromkeys(found))
