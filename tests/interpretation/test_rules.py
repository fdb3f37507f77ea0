"""Rule files: what loads, what is refused and where, and what conditions mean."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.interpretation_samples import SHOP, episode, state
from hypothesis import given
from hypothesis import strategies as st

from cramlite import data_folder
from cramlite.interpretation.condition_parser import ConditionError, parse_condition
from cramlite.interpretation.conditions import binds, mentions
from cramlite.interpretation.interpretation import interpret
from cramlite.interpretation.rules import RuleBook, load_rules
from cramlite.ontology.taxonomy import load_taxonomy
from cramlite.plugin import Phase, Predicate, Row, UserError
from cramlite_plugins.predicates.relations import all_predicates

TAXONOMY = load_taxonomy([data_folder("ontologies")])
PREDICATES = all_predicates()
TABLE = {p.name: p for p in PREDICATES}

GOOD = """task: soma:Grasping
roles: {Patient: soma:Patient}
source: a test
pre:
  - effector(Gripper)
  - not grasps(Gripper, _)
post:
  - grasps(Gripper, Patient)
explain: "{Patient} is grasped"
"""


def load(folder: Path, text: str, name: str = "rule.yaml") -> RuleBook:
    (folder / name).write_text(text)
    return load_rules([folder], PREDICATES, TAXONOMY)


def test_every_task_type_has_a_rule_with_a_source() -> None:
    rules = load_rules([data_folder("task_rules")], PREDICATES, TAXONOMY)
    assert len([r for r in rules if r.task != "cram:Shaking"]) == 29  # shaking is an extra
    for rule in rules:
        declared = set(TAXONOMY.fillers(rule.task, "cram:definesRole"))
        assert rule.source
        assert rule.clauses
        assert set(rule.roles.values()) <= declared, f"{rule.task}: {rule.roles} but the ontology says {declared}"


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("grasps(Gripper, Patient)", "graps(Gripper, Patient)", 8, "did you mean 'grasps'"),
        ("grasps(Gripper, Patient)", "grasps(Patient)", 8, "takes 2 arguments"),
        ("grasps(Gripper, Patient)", "not grasps(Gripper, Patient)", 2, "'Patient' is tested only"),
        ("grasps(Gripper, Patient)", "isa(Patient, soma:Cupp)", 8, "did you mean 'soma:Cup'"),
        ("grasps(Gripper, Patient)", "arm_moves()", 8, "write it under run"),
        ("grasps(Gripper, Patient)", "constrained_dof(Gripper, Patient)", 8, "compare it"),
        ("grasps(Gripper, Patient)", "grasps(Gripper, Patient) < 2", 8, "cannot be compared"),
        ("grasps(Gripper, Patient)", "grasps(Gripper, patient)", 8, "'patient' is no argument"),
        ("grasps(Gripper, Patient)", "grasps(Gripper, Patient", 8, "expected ','"),
        (
            "grasps(Gripper, Patient)",
            "'grasps(Gripper, Patient) and Weight < 3'",
            8,
            "nothing binds the variable 'Weight'",
        ),
        ("grasps(Gripper, Patient)", "[1, 2]", 8, "a condition is text"),
        ("explain:", "  - touches(Gripper, Patiemt)\nexplain:", 9, "did you mean the role 'Patient'"),
        ("not grasps(Gripper, _)", "not not $", 6, "is not part of a condition"),
        ("post:", "past:", 7, "unknown key 'past'"),
        ("soma:Grasping", "soma:Graspingg", 1, "did you mean 'soma:Grasping'"),
        ("soma:Grasping", "soma:Cup", 1, "unknown class"),
        ("soma:Patient}", "soma:Cup}", 2, "unknown class"),
        ("{Patient: soma:Patient}", "{patient: soma:Patient}", 2, "capitalised"),
        ("{Patient: soma:Patient}", "{Relatum: soma:RelatumRole}", 2, "is in no condition"),
        ("{Patient} is", "{Thing} is", 9, "variable 'Thing'"),
        ("source: a test", "source: ''", 3, "'source' is missing"),
    ],
)
def test_mistakes_are_refused_with_file_and_line(tmp_path: Path, old: str, new: str, line: int, words: str) -> None:
    assert load(tmp_path, GOOD)
    with pytest.raises(UserError) as caught:
        load(tmp_path, GOOD.replace(old, new))
    assert f"rule.yaml:{line}:" in str(caught.value)
    assert words in str(caught.value)


def test_a_variable_of_one_condition_is_no_misspelt_role_beside_that_role(tmp_path: Path) -> None:
    assert load(tmp_path, GOOD.replace("explain:", "  - touches(Patients, Patient)\nexplain:"))
    assert load(tmp_path, GOOD.replace("explain:", "  - touches(Gripper, Support)\nexplain:"))


def test_the_documented_rule_loads(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "reference" / "rules.md").read_text()
    (rule,) = load(tmp_path, page.split("```yaml\n")[1].split("```")[0])
    assert rule.task == "soma:Pouring"
    assert len(rule.clauses) == 6


def test_two_rules_for_one_task_are_refused(tmp_path: Path) -> None:
    load(tmp_path, GOOD)
    with pytest.raises(UserError, match="has a rule already in"):
        load(tmp_path, GOOD, "second.yaml")


def test_two_predicates_of_one_name_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="Two plugins define the predicate 'grasps'"):
        load_rules([tmp_path], [*PREDICATES, TABLE["grasps"]], TAXONOMY)


def test_a_new_sensor_relation_is_a_plugin(tmp_path: Path) -> None:
    def warm(phase: Phase, _thing: str | None) -> Iterator[Row]:
        yield ("product",)

    (tmp_path / "rule.yaml").write_text(GOOD.replace("- grasps(Gripper, Patient)", "- warm(Patient)"))
    rules = load_rules([tmp_path], [*PREDICATES, Predicate("warm", 1, warm)], TAXONOMY)
    sample = episode(SHOP, [state("contact", "product", "basket", 0, 1)])
    assert interpret(sample, rules, TAXONOMY).actions[0].matches[0].roles == {"Patient": "product"}


def rows_of(name: str, *rows: Row) -> Predicate:
    return Predicate(name, len(rows[0]) if rows else 1, lambda _phase, *_arguments: rows)


FACTS = {
    p.name: p
    for p in (
        rows_of("on", ("cup", "table"), ("jar", "table"), ("cup", "tray")),
        rows_of("blue", ("cup",)),
        rows_of("red", ("jar",)),
        Predicate("weight", 1, lambda _p, *_a: [("cup", 2.0), ("jar", 3.0)], value=True),
        rows_of("none"),
    )
}


def solutions(text: str, **binding: str) -> list[dict[str, str | float]]:
    sample = interpret(episode((), [state("contact", "a", "b", 0, 1)]), (), TAXONOMY)
    assert sample.count() == 0
    from cramlite.plugin import Timeline

    phase = Timeline(episode((), []), TAXONOMY).instant(0.0)
    return list(parse_condition(text, "pre", FACTS, TAXONOMY).solve(phase, dict(binding)))


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("on(X, Y)", 3),
        ("on(X, _)", 3),
        ("on(X, Y) and blue(X)", 2),
        ("on(X, Y) and not blue(X)", 1),
        ("on(X, X)", 0),
        ("not on(X, Y)", 0),
        ("not none(X)", 1),
        ("blue(X) or red(X)", 2),
        ("blue(X) or blue(X)", 1),
        ("every blue(X) -> on(X, _)", 1),
        ("every on(X, _) -> blue(X)", 0),
        ("every none(X) -> blue(X)", 1),
        ("every on(X, Y) and blue(X) -> not red(X)", 1),
        ("blue(X) and weight(X) < 3", 1),
        ("blue(X) and weight(X) >= 3", 0),
        ("on(X, Y) and on(Z, Y) and X != Z", 2),
        ('on("jar", Y)', 1),
        ("(blue(X) or red(X)) and on(X, Y)", 3),
    ],
)
def test_what_conditions_mean(text: str, count: int) -> None:
    assert len(solutions(text)) == count


def test_a_bound_variable_restricts() -> None:
    assert solutions("on(X, Y)", X="jar") == [{"X": "jar", "Y": "table"}]
    assert solutions("not blue(X)", X="jar") == [{"X": "jar"}]
    assert not solutions("not blue(X)", X="cup")


def test_only_what_both_sides_of_or_bind_is_bound() -> None:
    condition = parse_condition("on(X, Y) or blue(X)", "pre", FACTS, TAXONOMY)
    assert binds(condition) == {"X"}
    assert mentions(condition) == {"X", "Y"}


@given(st.text(alphabet='abXY_(),.->orntevyd <2:" ', max_size=40))
def test_no_text_crashes_the_condition_reader(text: str) -> None:
    with contextlib.suppress(ConditionError):
        parse_condition(text, "pre", FACTS, TAXONOMY)


@pytest.mark.parametrize("text", ["(" * 3000, "not " * 3000, "every blue(X) -> " * 3000])
def test_deep_nesting_is_refused(text: str) -> None:
    with pytest.raises(ConditionError, match="inside each other"):
        parse_condition(text, "pre", FACTS, TAXONOMY)


def test_the_order_of_conditions_never_changes_the_meaning(tmp_path: Path) -> None:
    lines = [
        "effector(Gripper)",
        "grasps(Gripper, Patient)",
        "not supports(_, Patient)",
        "every touches(Patient, X) -> chain(X)",
    ]
    sample = episode(
        SHOP,
        [
            state("grasp", "hand", "product", 0, 2),
            state("contact", "hand", "product", 0, 2),
            state("contact", "product", "basket", 1, 2),
            state("contact", "basket", "hanger", 1.5, 2),
        ],
    )
    answers = []
    for order in itertools.permutations(lines):
        text = GOOD[: GOOD.index("pre:")] + "pre:\n" + "".join(f"  - {c}\n" for c in order) + 'explain: "x"\n'
        found = interpret(sample, load(tmp_path, text), TAXONOMY, merge=False)
        answers.append([[m.roles for m in a.matches] for a in found.actions])
    assert answers[0] == [[{"Patient": "product"}], [], []]
    assert all(a == answers[0] for a in answers)
