"""Learning of a task from recorded episodes; the result is a proposal, which a person reviews."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..base.errors import UserError
from ..base.value import replace
from ..interpretation.conditions import atoms
from ..interpretation.path_predicate import path_predicate, rest_predicate
from ..interpretation.rules import Rule
from ..interpretation.timeline import Predicate
from ..interpretation.turn_predicate import turn_predicate
from ..testing.skeleton import camel
from .example import Example, Library, Marked, example, solutions
from .learner import Learned, covers, learn, left_out
from .procedure import Deviation, deviations
from .proposal import Proposal, propose, steps_of
from .shown_motion import ShownMotion, shown_motion
from .shown_rest import ShownRest, shown_rest
from .shown_swing import shown_swing
from .shown_turn import ShownTurn, shown_turn
from .span import Span

if TYPE_CHECKING:
    from ..model.episode import Episode
    from ..plugin.catalogue import Knowledge

OUTLIER = 0.4
"""Share of the spread of all examples: if leaving one example out reduces the spread to less than this, that example shows something
else."""
Shown = tuple["Episode", float | None, float | None]
"""An episode, and when the task began and ended in it [s]; None for the ends of the episode."""


def learn_task(
    name: str, shown: Sequence[Shown], knowledge: Knowledge, *, refused: Sequence[Episode] = (), known: Sequence[Episode] = ()
) -> Proposal:
    """Learn a task from demonstrations.

    Args:
        name: of the task, in small letters, e.g. "stirring".
        shown: demonstrations, at least one.
        knowledge: tasks, rules, predicates and classes that are known.
        refused: episodes in which the task was not done.
        known: episodes of other tasks; what known tasks explain in them is no example.

    Raises:
        UserError: an interval is empty, the examples have nothing in common, or they contradict those that were refused.
    """
    rules, taxonomy = knowledge.rules, knowledge.taxonomy
    named = _named_apart([*(e for e, _, _ in shown), *refused, *known])
    examples = [example(Marked(named[id(e)], start, end), rules, taxonomy) for e, start, end in shown]
    refused, known = ([named[id(e)] for e in group] for group in (refused, known))
    others = [*Library(refused, taxonomy, strict=True).known(rules), *Library(known, taxonomy).known(rules)]
    motion = _shown(examples, rules, [k.span for k in others if k.strict])
    predicate = _predicate(motion, name)
    learned = learn(examples, others, knowledge.predicates, taxonomy, predicate)
    if predicate is None and (unlike := _unlike(learned)):
        raise UserError(unlike)
    wrong = [examples[k].span for k in learned.refused]
    proposal = propose(f"cram:{camel(name)}", learned, rules, taxonomy, wrong, motion)
    said = {str(k.span) for k in learned.others if k.strict}
    contradicted = [c for c in proposal.covered if c in said]
    if contradicted:
        first = ", ".join(str(e.span) for e in examples)
        raise UserError(
            f"The examples are contradictory: no condition tells {first} from {'; '.join(contradicted)}, given after --not. "
            "Mark intervals that differ (--interval), leave one of them out, or write a predicate for what differs."
        )
    return proposal


def _shown(examples: Sequence[Example], rules: Sequence[Rule], refused: Sequence[Span]) -> ShownMotion | ShownTurn | ShownRest | None:
    """Return what the examples share: a motion that no known task explains, else a turn, else a rest; None if they share none of these."""
    if motion := _motion(examples, rules):
        return motion.apart_from(refused)
    sets = [[e.span for k, e in enumerate(examples) if k not in out] for out in left_out(len(examples))]
    turn = next((found for kept in sets if (found := shown_turn(kept)) is not None), None)
    return turn or next((rest for kept in sets if (rest := shown_rest(kept)) is not None), None)


def _predicate(motion: ShownMotion | ShownTurn | ShownRest | None, name: str) -> Predicate | None:
    """Return the predicate by which a rule recognises a shown motion, turn or rest; None if nothing was shown."""
    if isinstance(motion, ShownTurn):
        return turn_predicate(f"turns_{name}", motion.axis, motion.least, motion.most)
    if isinstance(motion, ShownRest):
        return rest_predicate(f"rests_{name}", motion.least_s)
    return path_predicate(f"follows_{name}", motion.path) if motion else None


def _named_apart(episodes: Sequence[Episode]) -> dict[int, Episode]:
    """Return a dictionary of the episodes in which equal names are made different: "pour", "pour (2)".

    Its keys are the ``id()`` of the episodes.
    """
    found: dict[int, Episode] = {}
    taken: Counter[str] = Counter()
    for one in {id(e): e for e in episodes}.values():
        taken[one.name] += 1
        found[id(one)] = one if taken[one.name] == 1 else replace(one, name=f"{one.name} ({taken[one.name]})")
    return found


def _unlike(learned: Learned) -> str:
    """Return an error message if the examples show different known tasks and have no change in common; else ""."""
    tasks = [{task for task, _ in one.tasks} for one in learned.examples]
    if learned.cast.changes or len(tasks) < 2 or not all(tasks) or set.intersection(*tasks):
        return ""
    shown = "; ".join(f"{one.span} shows {', '.join(sorted(t))}" for one, t in zip(learned.examples, tasks, strict=True))
    return f"The examples are contradictory: {shown}, and nothing begins or ends in all of them. Leave out those that show another task."


def _motion(examples: Sequence[Example], rules: Sequence[Rule]) -> ShownMotion | None:
    """Return the motion that all examples share; None if there is none, or if known tasks explain it.

    One example may be left out as wrong.

    Any known task explains a straight stroke; a bent path only a task about the same thing whose rule
    measures the motion.
    """
    sets = [[e for k, e in enumerate(examples) if k not in out] for out in left_out(len(examples))]
    each: list[tuple[ShownMotion, list[Example]]] = []
    for shown in (shown_motion, shown_swing):  # about another thing, else about its own place
        each = each or [(m, kept) for kept in sets if (m := shown([e.span for e in kept])) is not None]
    if not each:
        return None
    least = min(each, key=lambda f: f[0].spread)
    whole = len(each[0][1]) == len(examples) and least[0].spread > OUTLIER * each[0][0].spread
    found, kept = each[0] if whole else least
    measuring = {r.task for r in rules if any(a.predicate.value for c in r.clauses if c.phase == "run" for a in atoms(c.condition))}
    explained = all(
        any(not found.bent or (task in measuring and about in roles.values()) for task, roles in one.tasks)
        or (found.path.anchor.own and any(about in b.values() for r in rules if r.task in measuring for b in solutions(r, one.span)))
        for one, (_, about) in zip(kept, found.fillers, strict=True)
    )
    return None if explained else found


def compared(proposal: Proposal, shown: Shown, knowledge: Knowledge) -> tuple[Deviation, ...]:
    """Return the deviations of another demonstration, or of an execution, from the procedure of a learned
    task.

    Raises:
        UserError: an interval is empty, the demonstration is not of the task, or no known tasks explain the examples.
    """
    one = example(Marked(*shown), knowledge.rules, knowledge.taxonomy)
    fillers = covers(proposal.learned, one.span)
    if proposal.procedure is None or not fillers:
        why = "known tasks do not explain every example" if proposal.procedure is None else f"the learned rule does not hold in {one.span}"
        raise UserError(f"The demonstration '{shown[0].name}' cannot be compared with the learned task: {why}.")
    return tuple(deviations(proposal.procedure, steps_of(one, fillers[0], proposal.roles)))
