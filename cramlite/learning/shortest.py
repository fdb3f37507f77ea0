"""Shortest set of conditions that describes examples: a weighted hitting set with exceptions, solved as an integer program.

Each filling of the roles in a stretch that is no example must be refuted by a chosen condition, or is an exception that is told beside the
rule. A rule's length is the bits of its conditions and of its exceptions. (SciPy's ``milp``: HiGHS, branch and bound.)
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from ..base.errors import PluginError
from ..base.value import Value
from .span import Truths

TIE = 1e-5
"""Description length that is added for each place that a condition stands later in the language [bits], so that the first of equally short
rules is found."""


class Group(Value, eq=False):
    """Group of role assignments that a rule should exclude; a rule that does not exclude all of them is longer by ``bits``.

    Args:
        refuted: for each filling the conditions that refute it, as bits of a whole number.
        bits: of the exception.
        narrow: bits that are paid where a filling is refuted by one condition alone.
    """

    refuted: frozenset[int]
    bits: float
    narrow: float = 0.0


class Wish(Value, eq=False):
    """Penalty of ``bits`` for a rule unless all its conditions hold in at least one recorded action of an
    example.

    Args:
        false: of alternatives, the conditions that do not hold in each, as bits of a whole number.
        bits: that are paid where a condition is chosen in each of them that does not hold there.
    """

    false: tuple[int, ...]
    bits: float


class Problem(Value, eq=False):
    """Problem of finding the shortest rule.

    Args:
        bits: (conditions,) the length of each.
        groups: of fillings.
        wishes: see there.
        needed: sets of conditions, one of each of which must be chosen: those that say who fills a role.
        told: sets of conditions, and the bits that are paid if none of a set is chosen: changes that are left untold.
    """

    bits: npt.NDArray[np.float64]
    groups: Sequence[Group]
    wishes: Sequence[Wish]
    needed: Sequence[Sequence[int]]
    told: Sequence[tuple[Sequence[int], float]]


class Shortest(Value):
    """Shortest rule of a learning problem: the indices of its conditions, and its description length
    [bit]."""

    chosen: tuple[int, ...]
    bits: float


def masks(refuted: Truths) -> list[int]:
    """Return each column of a table of truth values as an integer, in which bit k is set if row k is true."""
    packed = np.packbits(refuted, axis=0, bitorder="little")
    return [int.from_bytes(column.tobytes(), "little") for column in packed.T]


def minimal(found: Iterable[int]) -> frozenset[int]:
    """Return the sets that have no proper subset among the given sets (sets are bits of integers).

    A choice that meets all of these meets all given ones.
    """
    kept: list[int] = []
    for mask in sorted(set(found), key=lambda m: (m.bit_count(), m)):
        if not any(mask & other == other for other in kept):
            kept.append(mask)
    return frozenset(kept)


def _rows_of(mask: int) -> list[int]:
    return [k for k, bit in enumerate(reversed(bin(mask)[2:])) if bit == "1"]


def merged(groups: Iterable[Group]) -> list[Group]:
    """Merge groups of role assignments that the same conditions exclude, and add up their description lengths [bit]."""
    found: dict[frozenset[int], Group] = {}
    for group in groups:
        if group.refuted:
            known = found.get(group.refuted, Group(group.refuted, 0.0))
            found[group.refuted] = Group(group.refuted, known.bits + group.bits, known.narrow + group.narrow)
    return [*found.values()]


def shortest(problem: Problem) -> Shortest:
    """Return the shortest rule of a learning problem: the choice of conditions that costs the fewest bits.

    Raises:
        PluginError: the solver found none, though each problem has a solution.
    """
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_array

    rows, lower = _Rows(), list[float]()
    count = len(problem.bits)
    weights = [*(problem.bits + TIE * np.arange(count))]
    for group in merged(problem.groups):
        weights.append(group.bits)
        for mask in sorted(group.refuted):
            rows.add([*_rows_of(mask), len(weights) - 1], 1.0)
            lower.append(1.0)
    for sets, bits in [(s, 0.0) for s in problem.needed] + list(problem.told):
        weights += [bits] if bits else []
        rows.add([*sets, *([len(weights) - 1] if bits else [])], 1.0)
        lower.append(1.0)
    for wish in problem.wishes:
        _wish(wish, weights, rows, lower)
    matrix = csr_array((rows.values, (rows.rows, rows.columns)), shape=(len(lower), len(weights)))
    found = milp(
        np.array(weights), integrality=np.ones(len(weights)), bounds=Bounds(0, 1),
        constraints=[LinearConstraint(matrix, lb=np.array(lower))] if lower else [], options={"mip_rel_gap": 0.0},
    )  # fmt: skip
    if found.x is None:
        raise PluginError(f"The shortest rule was not found: {found.message}")
    return Shortest(tuple(int(k) for k in np.flatnonzero(found.x[:count] > 0.5)), float(found.fun))


def _wish(wish: Wish, weights: list[float], rows: _Rows, lower: list[float]) -> None:
    """Add a soft constraint (a wish) to the integer program: if it is violated, its penalty [bits] is added to the objective.

    It is met if all chosen conditions hold in at least one of its alternatives.
    """
    first = len(weights)
    weights += [0.0] * len(wish.false)
    for k, mask in enumerate(wish.false):
        false = _rows_of(mask)
        if false:
            rows.add([*false, first + k], -1.0, [-1.0] * len(false) + [-float(len(false))])
            lower.append(-float(len(false)))
    weights.append(wish.bits)
    rows.add([*range(first, len(weights))], 1.0)
    lower.append(1.0)


def widened(problem: Problem, chosen: Sequence[int]) -> tuple[int, ...]:
    """Return a rule's chosen conditions and further ones, the best first, each of which shortens the description length [bits].

    A condition saves the ``narrow`` bits of a binding by being the second condition that refutes the binding.
    """
    groups = [g for g in merged(problem.groups) if g.narrow]
    bits, found = problem.bits + TIE * np.arange(len(problem.bits)), set(chosen)
    while True:
        left = [(g.narrow / len(g.refuted), mask) for g in groups for mask in g.refuted]
        taken = sum(1 << k for k in found)
        narrow = [(paid, mask & ~taken) for paid, mask in left if (mask & taken).bit_count() == 1]
        saved = np.array([sum(paid for paid, mask in narrow if mask >> k & 1) for k in range(len(bits))])
        best = int(np.argmax(saved - bits))
        if saved[best] <= bits[best]:
            return tuple(sorted(found))
        found.add(best)


class _Rows:
    """Coefficients of a sparse matrix, row by row."""

    def __init__(self) -> None:
        self.values, self.rows, self.columns, self.count = list[float](), list[int](), list[int](), 0

    def add(self, columns: Sequence[int], value: float, values: Sequence[float] = ()) -> None:
        self.values += list(values) or [value] * len(columns)
        self.rows += [self.count] * len(columns)
        self.columns += [int(c) for c in columns]
        self.count += 1
