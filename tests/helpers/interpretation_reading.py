"""Hand-made episodes read with the shipped rules: what the tests of interpretation have in common."""

from __future__ import annotations

from cramlite import Interpretation, data_folder
from cramlite.interpretation.interpretation import interpret
from cramlite.interpretation.rules import load_rules
from cramlite.model import Entity, Episode, Pose
from cramlite.ontology.taxonomy import load_taxonomy
from cramlite.plugin import Interpreted
from cramlite_plugins.predicates.relations import all_predicates

TAXONOMY = load_taxonomy([data_folder("ontologies")])
RULES = load_rules([data_folder("task_rules")], all_predicates(), TAXONOMY)

BOX = Entity("box", ("cram:BoxedProduct",), size=(0.05, 0.05, 0.1))
TABLE = Entity("table", ("soma:Table",), pose=Pose((0.5, 0, 0)), size=(1, 1, 0.02))


def read(sample: Episode, merge: bool = True) -> Interpretation:
    return interpret(sample, RULES, TAXONOMY, merge=merge)


def tasks(one: Interpreted) -> set[str]:
    return {m.task for m in one.matches}


def at(found: Interpretation, time: float) -> Interpreted:
    """Return the interpreted action that is in progress at a time."""
    return next(a for a in found.actions if a.start <= time < a.end)
