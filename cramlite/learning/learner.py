"""Learner of rules: the shortest rule that separates the spans in which a task was done from all known other actions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import combinations, permutations

import numpy as np

from ..base.errors import UserError
from ..base.value import Value, replace
from ..interpretation.timeline import Predicate
from ..ontology.taxonomy import Taxonomy
from .example import Example, Known
from .literal import ANY, PHASES, Language, Literal
from .roles import MOST_ROLES, Cast, casts, follows, own_changes, recorded
from .shortest import Group, Problem, Wish, masks, minimal, shortest, widened
from .span import Span
from .tables import Tables

EXCEPTION, SAID = 20.0, 40.0
"""Penalties of a learned rule for each span that it misjudges, and for each misjudged span that a person marked as not the task [bits]:
more than one or two of the longest conditions, which are about a class (18)."""
NARROW = 1.0
"""Penalty of a learned rule for a counterexample that only one of its conditions excludes [bits], so that rules keep a margin, as their
bounds do."""
UNTOLD = 17.0
"""Penalty of a learned rule for each change in all examples that it does not state, and for each thing that moves in all examples and fills
no role [bits]: three names of one thing among fifty, as in readings (ranking.py)."""
UNSEEN = 2.0
"""Penalty of a learned rule if no single action of an example fulfils it, but only the marked span [bits]; each example counts for an equal
share."""
ROLE = 1.0
"""Description length of each role of a learned rule [bits]."""
WRONG_OF = 5
"""Least number of examples of which one may be left out as wrong."""
BOUNDS = 3
"""Number of bounds of a measured value that are tried on each side of the examples' values."""


class Learned(Value, eq=False):
    """Rule that was learned, with the examples and counterexamples that it separates.

    Args:
        literals: its conditions.
        cast: who fills the roles in each example.
        examples: it was learned from.
        refused: examples that it does not cover, by their numbers: taken to be wrong.
        others: stretches that are not the task.
        language: of its conditions.
        bits: its length, with all that it leaves untold.
    """

    literals: tuple[Literal, ...]
    cast: Cast
    examples: tuple[Example, ...]
    refused: tuple[int, ...]
    others: tuple[Known, ...]
    language: Language
    bits: float


def language_of(predicates: Sequence[Predicate], taxonomy: Taxonomy, spans: Sequence[Span], motion: Predicate | None = None) -> Language:
    """Return the predicates that conditions of a learned rule may use, and the number of classes.

    Args:
        motion: the predicate of the motion that the examples show.
    """
    unary = [p for p in predicates if p.timeless and p.complete and p.arity == 1 and not p.value]

    def of_all(meant: Callable[[Span], set[str]]) -> str | None:
        for p in unary:
            if all({str(r[0]) for r in s.phases["pre"].rows(p, (None,))} == meant(s) for s in spans):
                return p.name
        return None

    hand, whole = of_all(lambda s: {s.effector or ""}), of_all(lambda s: set(s.things))
    usable = [p for p in predicates if not p.classes or (p.timeless and p.arity == 2 and len(p.classes) == 1)]
    usable += [motion] if motion else []
    return Language({p.name: p for p in usable}, hand, whole, len(taxonomy.classes), motion.name if motion else None)


def learn(
    examples: Sequence[Example], others: Sequence[Known], predicates: Sequence[Predicate], taxonomy: Taxonomy,
    motion: Predicate | None = None,
) -> Learned:
    """Learn the shortest rule that holds in all examples and in no action that known tasks explain.

    Args:
        motion: the predicate of the motion that the examples show.

    Raises:
        UserError: the examples have nothing in common that changes or happens, or cannot be told from what is no example.
    """
    spans = [e.span for e in examples]
    rest = (*others, *(k for e in examples for k in e.around))
    language = language_of(predicates, taxonomy, [*spans, *(k.span for k in rest)], motion)
    tables = Tables(language, [k.span for k in rest]) if rest else None
    found = [_learned(language, examples, rest, tables, taxonomy, out) for out in left_out(len(examples))]
    best = min((f for f in found if f is not None), key=lambda f: f.bits, default=None)
    if best is None:
        raise UserError(_nothing(examples, Tables(language, spans)))
    return best


def left_out(count: int) -> list[tuple[int, ...]]:
    """Return the sets of examples that may be left out as wrong, as tuples of indices: first none, then each
    single one."""
    return [(), *((k,) for k in range(count) if count >= WRONG_OF)]


def _learned(
    language: Language, examples: Sequence[Example], rest: Sequence[Known], tables: Tables | None, taxonomy: Taxonomy,
    left_out: tuple[int, ...],
) -> Learned | None:
    kept = [e for k, e in enumerate(examples) if k not in left_out]
    shown = Tables(language, [e.span for e in kept])
    choices = [c for roles in range(MOST_ROLES + 1) for c in casts(shown, roles)]
    if language.motion is None and not any(c.changes for c in choices) and all(own_changes(shown, k) for k in range(len(kept))):
        return None  # something begins or ends in each, and it is another thing in each
    if language.motion and any(c.changes for c in choices):  # what is recorded with a motion is what it is for
        choices = [replace(c, measured=()) for c in choices]
    told = max((c.told for c in choices), default=0)
    lapses = _Lapses(rest, tables)
    best: Learned | None = None
    for cast in choices:
        sure = _sure(rest, tables, cast, frozenset.intersection(*(e.idle for e in kept)))
        others = [k.span for k, s in zip(rest, sure, strict=True) if s]
        literals = (*cast.common, *_classes(taxonomy, shown, cast), *_bounds(shown, cast, others))
        known_spans = [(k, r) for k, (r, s) in enumerate(zip(rest, sure, strict=True)) if s]
        problem = _problem(shown, tables, literals, cast, kept, known_spans)
        problem = replace(problem, bits=problem.bits + lapses.bits(literals, cast.roles, len(kept)))
        if not all(problem.needed):
            continue
        found = shortest(problem)
        bits = found.bits + ROLE * cast.roles + EXCEPTION * len(left_out) + UNTOLD * (told - cast.told)
        if best is None or bits < best.bits - 1e-3:
            known = tuple(k for k, s in zip(rest, sure, strict=True) if s)
            best = Learned(tuple(literals[k] for k in widened(problem, found.chosen)), cast, tuple(kept), left_out, known, language, bits)
    return best


class _Lapses:
    """How often a condition that holds in some recorded actions of a known task fails in another action of
    that task.

    So much a measured condition is worth that holds in all examples: people differ in how wide they open a hand, and in what is near.
    Recorded states are what tasks are about.

    Args:
        rest: actions that known tasks explain.
        tables: of them; None where there are none.
    """

    def __init__(self, rest: Sequence[Known], tables: Tables | None) -> None:
        self.tables, self._known = tables, dict[tuple[Literal, int], float]()
        self.groups: dict[str, list[tuple[int, Known]]] = {}
        for k, one in enumerate(rest):
            if one.task:
                self.groups.setdefault(one.task, []).append((k, one))

    def bits(self, literals: Sequence[Literal], roles: int, examples: int) -> np.ndarray:
        """Return for each condition the cost [bits] of the failures that are expected of it in
        ``examples`` further examples."""
        return np.array([EXCEPTION * examples * self._share(one, roles, examples) for one in literals])

    def _share(self, literal: Literal, roles: int, examples: int) -> float:
        """Estimate the probability that a condition fails in the next span of a known task, having held in
        ``examples`` spans of it."""
        if self.tables is None or recorded(self.tables.language, literal):
            return 0.0
        named = sorted(literal.roles)
        same = replace(literal, slots=tuple(named.index(s) + 1 if s > 0 else s for s in literal.slots))
        if (same, examples) not in self._known:
            truth = self.tables.truth(literal, roles)
            table = truth.reshape(len(truth), *(n for r, n in enumerate(truth.shape[1:], 1) if r in named))
            self._known[same, examples] = lapsed(self._held(table, len(named)), examples)
        return self._known[same, examples]

    def _held(self, table: np.ndarray, roles: int) -> Iterator[list[bool]]:
        """Yield for each known task, and each choice of its roles, whether a condition holds in each span in which the task was done."""
        assert self.tables is not None
        for group in self.groups.values():
            for names in permutations(group[0][1].roles, roles):
                found = []
                for k, one in group:
                    things = self.tables.spans[k].things
                    places = [things.index(f) for n in names if (f := one.roles.get(n, "")) in things]
                    if len(places) == roles:
                        found.append(bool(table[(k, *places)]))
                yield found


def lapsed(groups: Iterable[list[bool]], examples: int) -> float:
    """Estimate the probability, by Laplace's rule, that a condition fails in the next span of a task,
    having held in ``examples`` spans of it."""
    kept = lost = 0.0
    for held in groups:
        count, true = len(held), sum(held)
        first = min(examples, count - 1)
        if first > 0 and true >= first:
            chance = math.comb(true, first) / math.comb(count, first)
            lost += chance * (count - true) / (count - first)
            kept += chance * (true - first) / (count - first)
    return lost / (kept + lost + 1.0)


def _sure(rest: Sequence[Known], tables: Tables | None, cast: Cast, idle: frozenset[str]) -> list[bool]:
    """Return for each action outside the examples whether it certainly is a counterexample of the learned task.

    That is so if a known task explains it.

    An action with the examples' changes must be explained in these changes, else it may be the learned task.
    A task without changes explains, unless the examples have the same one.
    """
    if tables is None:
        return []
    alike = tables.truths(cast.changes, cast.roles).all(axis=0) & tables.valid(cast.roles)
    changes = {c.predicate for c in cast.changes}
    return [
        k.strict or k.named or (k.claim is not None and k.task not in idle and (not changes or bool(changes & k.explained) or not same))
        for k, same in zip(rest, np.asarray(alike.any(axis=1)), strict=True)
    ]


def _problem(
    shown: Tables, tables: Tables | None, literals: Sequence[Literal], cast: Cast, examples: Sequence[Example],
    known: Sequence[tuple[int, Known]],
) -> Problem:
    language, roles = shown.language, cast.roles
    groups = _groups(shown, literals, cast)
    if tables is not None:
        refuted, valid = ~tables.truths(literals, roles), tables.valid(roles)
        groups += [Group(minimal(masks(refuted[:, k, valid[k]])), SAID if one.strict else EXCEPTION, NARROW) for k, one in known]
    wishes = []
    for one, fillers in zip(examples, cast.fillers, strict=True):
        if one.actions:
            inside = Tables(language, one.actions)
            false = ~inside.truths(literals, roles)
            each = (masks(false[:, k, [inside.place(k, fillers)]])[0] for k in range(len(one.actions)))
            wishes.append(Wish(tuple(each), UNSEEN / len(examples)))
    telling = 0
    for group in groups:
        for mask in group.refuted:
            telling |= mask
    needed = [[k for k, one in enumerate(literals) if _happens(language, one) and (telling >> k & 1 or not groups)]]
    needed += [[k for k, one in enumerate(literals) if role in one.binds] for role in range(1, roles + 1)]
    changes = [
        ([k for k, one in enumerate(literals) if one == change or _tells(language, one, change)], UNTOLD) for change in cast.changes
    ]
    if language.motion and not cast.changes:  # then the motion is all that happens
        needed += [[k for k, one in enumerate(literals) if of_motion(language, one)]]
    if language.motion:  # what happens is the motion, whatever else may be measured
        changes += [([k for k, one in enumerate(literals) if of_motion(language, one)], UNTOLD)]
    else:
        changes += [([k for k, one in enumerate(literals) if one in measured], UNTOLD) for measured in cast.measured]
    return Problem(np.array([language.bits(one, roles) for one in literals]), groups, wishes, needed, changes)


def _groups(shown: Tables, literals: Sequence[Literal], cast: Cast) -> list[Group]:
    """Return for each example the wrong assignments of things to roles, which the learned rule should exclude."""
    refuted, valid = ~shown.truths(literals, cast.roles), shown.valid(cast.roles)
    found = []
    for k, place in enumerate(cast.places):
        others = valid[k].copy()
        others[place] = False
        found.append(Group(minimal(masks(refuted[:, k, others])), EXCEPTION))
    return found


def _happens(language: Language, literal: Literal) -> bool:
    """Check whether a condition is about an event: a beginning, an end, something during the action, or an
    agent that rests."""
    still = language.predicates[literal.predicate].phases == {"run"} and not literal.roles and ANY not in literal.slots
    return literal.kind in ("begins", "ends") or (literal.phase == "run" and (still or not literal.denied))


def of_motion(language: Language, literal: Literal) -> bool:
    """Check whether a condition of a learned rule is the one on the motion that all examples show."""
    return literal.predicate == language.motion and not literal.denied and len(literal.roles) == len(literal.slots)


def _tells(language: Language, one: Literal, change: Literal) -> bool:
    return one.kind == change.kind and follows(language, change, one)


def _classes(taxonomy: Taxonomy, shown: Tables, cast: Cast) -> Iterator[Literal]:
    """Yield conditions on the class of the thing in a role, or of a part of it, that hold in all examples."""
    for predicate in shown.language.predicates.values():
        for role in range(cast.roles if predicate.classes else 0):
            shared: set[str] | None = None
            for span, fillers in zip(shown.spans, cast.fillers, strict=True):
                parts = [n for n, wholes in span.timeline.wholes.items() if fillers[role] in wholes]
                above = {c for n in parts for t in span.timeline.types(n) for c in taxonomy.ancestors(t)}
                known = {c for c in above if c in taxonomy.classes and span.of_class(predicate, c)[span.things.index(fillers[role])]}
                shared = known if shared is None else shared & known
            yield from (Literal(predicate.name, "class", "pre", (role + 1,), class_=c) for c in sorted(shared or ()))


def _bounds(tables: Tables, cast: Cast, others: Sequence[Span]) -> Iterator[Literal]:
    """Yield conditions that bound a measured value, half way between the examples and the nearest counterexample."""
    for predicate in tables.language.predicates.values():
        if not predicate.value or predicate.arity > cast.roles:
            continue
        for slots in [s for s in np.ndindex(*(cast.roles,) * predicate.arity) if len(set(s)) == len(s)]:
            for phase in (p for p in PHASES if p in predicate.phases):
                shown = [
                    float(s.values(predicate, phase)[tuple(s.things.index(f[k]) for k in slots)])
                    for s, f in zip(tables.spans, cast.fillers, strict=True)
                ]
                else_ = sorted({float(v) for s in others for v in s.values(predicate, phase).reshape(-1) if not math.isnan(v)})
                if not any(math.isnan(v) for v in shown):
                    for kind, bound in _between(min(shown), max(shown), else_):
                        yield Literal(predicate.name, kind, phase, tuple(k + 1 for k in slots), bound=bound)


def _between(low: float, high: float, others: Sequence[float]) -> Iterator[tuple]:  # type: ignore[type-arg]
    below, above = [v for v in others if v < low][-BOUNDS:], [v for v in others if v > high][:BOUNDS]
    yield from (("at_least", _rounded(v, low)) for v in below)
    yield from (("at_most", _rounded(high, v)) for v in above)


def _rounded(low: float, high: float) -> float:
    """Return a number near the middle of two numbers, with the fewest digits that keep it between them."""
    middle = (low + high) / 2
    for digits in range(1, 16):
        short = float(f"{middle:.{digits}g}")
        if low < short < high:
            return short
    return middle


def _nothing(examples: Sequence[Example], tables: Tables) -> str:
    names = "; ".join(str(e.span) + _begun(own_changes(tables, k)) for k, e in enumerate(examples))
    return (
        f"The examples have nothing in common that begins, ends or happens: {names}. Either one of them shows another task, or no "
        "predicate describes what makes the task; 'cramlite new predicate' writes one of your own."
    )


def _begun(changes: Sequence[Literal]) -> str:
    """Name the predicates that begin or end in an example, as text such as ": there begins supports and there ends
    holds"."""
    names = {kind: sorted({c.predicate for c in changes if c.kind == kind}) for kind in ("begins", "ends")}
    said = [f"{kind} {', '.join(found)}" for kind, found in names.items() if found]
    return f": {' and '.join(f'there {words}' for words in said)}" if said else ""


def covers(learned: Learned, span: Span, literals: Sequence[Literal] | None = None) -> tuple[tuple[str, ...], ...]:
    """Return the assignments of things to roles for which a rule holds in a span of an episode.

    Args:
        literals: instead of the rule's own.
    """
    asked = learned.literals if literals is None else tuple(literals)
    roles, tables = learned.cast.roles, Tables(learned.language, [span])
    holds = (tables.truths(asked, roles).all(axis=0) & tables.valid(roles))[0]
    return tuple(tables.names(0, int(p), roles) for p in np.flatnonzero(holds))


def conditions(learned: Learned, names: Sequence[str]) -> Mapping[str, list[str]]:
    """Return the conditions of a learned rule as texts for its file, by phase: before, during and after the task.

    ``names`` are the variables of the agent and of the roles.
    """
    found: dict[str, list[str]] = {phase: [] for phase in PHASES}
    language = learned.language
    if language.hand and any(0 in one.slots for one in learned.literals):
        found["pre"].append(f"{language.hand}({names[0]})")
    if language.thing:
        found["pre"] += [f"{language.thing}({name})" for name in names[1:]]
    for one in learned.literals:
        for phase, text in one.texts(names):
            if text not in found[phase]:
                found[phase].append(text)
    found["pre" if language.thing else "post"] += [f"{one} != {other}" for one, other in combinations(names[1:], 2)]
    return found
