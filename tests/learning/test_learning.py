"""Tasks are learned from recorded people: the shortest rule, its evidence, a package that works, and reasons where nothing is learned."""

from __future__ import annotations

import itertools
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import Run
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite import Engine, find_scenario, read_scenario
from cramlite.engine.recording import record_episode, tasks_in_words
from cramlite.interpretation.rules import load_rules
from cramlite.interpretation.timeline import Segment
from cramlite.learning.from_episodes import compared, learn_task
from cramlite.learning.learner import covers
from cramlite.learning.package import page_text, write_package
from cramlite.learning.proposal import Proposal
from cramlite.learning.shortest import Group, Problem, Wish, minimal, shortest, widened
from cramlite.learning.trial import trials
from cramlite.model import Episode
from cramlite.plugin import UserError

ENGINE = Engine()
PLACED = "Grasping block, PickingUp block floor, Placing block shelf"


@cache
def episode(scenario: str, seed: int, tasks: str = "") -> Episode:
    """What a person shows; recorded once."""
    import tempfile

    chosen = tasks_in_words(tasks, ENGINE.knowledge.tasks) if tasks else ()
    with tempfile.TemporaryDirectory() as folder:
        record_episode(read_scenario(find_scenario(scenario)), ENGINE, seed=seed, out=Path(folder) / "shown", tasks=chosen)
        return ENGINE.read_episode(Path(folder) / "shown")


@cache
def fetched() -> Proposal:
    """A task of taking a block from the floor onto a shelf, from three whole demonstrations."""
    shown = [(episode("tasks/placing", seed, PLACED), None, None) for seed in (1, 2, 3)]
    known = [episode("tasks/grasping", 1), episode("tasks/releasing", 1), episode("tasks/picking_up", 1, "PickingUp block floor")]
    return learn_task("shelving", shown, ENGINE.knowledge, known=known)


# The rule


def test_who_changes_has_the_roles() -> None:
    assert [set(f) for f in fetched().fillers] == [set(fetched().fillers[0])] * 3
    assert {"block", "shelf"} <= set(fetched().fillers[0])


def test_it_says_what_changes() -> None:
    asked = [f"{phase}: {text}" for phase, texts in fetched().rule.items() for text in texts]
    assert any(a.startswith("post: supports(") for a in asked)
    assert any(a.startswith("post: not supports(") for a in asked)  # by what it stood on


def test_known_tasks_in_order_are_how_it_is_done() -> None:
    tasks = [step.task for step in fetched().steps]
    assert tasks[:2] == ["soma:Grasping", "soma:PickingUp"]
    assert tasks.index("soma:PuttingDown") < tasks.index("soma:Releasing")


def test_an_unseen_person_is_recognised_and_other_tasks_are_not() -> None:
    from cramlite.interpretation.timeline import Timeline
    from cramlite.learning.span import Span

    def fillings(scenario: str, tasks: str) -> object:
        timeline = Timeline(episode(scenario, 9, tasks), ENGINE.knowledge.taxonomy)
        return covers(fetched().learned, Span(timeline, *timeline.episode.span))

    assert fillings("tasks/placing", PLACED) == (fetched().fillers[0],)
    for scenario in ("tasks/grasping", "tasks/releasing", "tasks/pushing"):
        assert fillings(scenario, "") == ()


def test_the_rule_file_means_what_was_learned(tmp_path: Path) -> None:
    folder = write_package(fetched(), "shelving", tmp_path / "made")[0]
    engine = Engine(files=[folder / "cramlite_shelving" / "__init__.py"])
    rule = next(r for r in engine.knowledge.rules if r.task == "cram:Shelving")
    for example in fetched().learned.examples:
        phases, found = example.span.timeline.phases(Segment(example.span.start, example.span.end)), [{}]
        for clause in rule.written_order:
            found = [f for b in found for f in clause.condition.solve(phases[clause.phase], b)]
        by_file = {tuple(str(b[role]) for role in rule.roles) for b in found}
        assert by_file == set(covers(fetched().learned, example.span)) != set()


def test_no_thing_has_two_roles() -> None:
    learned = fetched().learned
    for taken in ((), learned.literals):
        found = covers(learned, learned.examples[0].span, taken)
        assert found and all(len(set(things)) == learned.cast.roles for things in found)
    assert sum(" != " in text for text in fetched().rule["pre"]) == learned.cast.roles * (learned.cast.roles - 1) // 2


def test_one_who_leaves_out_a_condition_covers_no_less() -> None:
    learned = fetched().learned
    for one in learned.literals:
        rest = [other for other in learned.literals if other != one]
        assert set(covers(learned, learned.examples[0].span)) <= set(covers(learned, learned.examples[0].span, rest))


def test_the_same_input_gives_the_same_text() -> None:
    shown = [(episode("tasks/placing", seed, PLACED), None, None) for seed in (1, 2, 3)]
    known = [episode("tasks/grasping", 1), episode("tasks/releasing", 1), episode("tasks/picking_up", 1, "PickingUp block floor")]
    again = learn_task("shelving", shown, Engine().knowledge, known=known)
    assert page_text(again) == page_text(fetched()) and again.rule == fetched().rule


def test_one_wrong_example_of_five_is_named() -> None:
    shown = [(episode("tasks/releasing", seed), 2.0, None) for seed in (1, 2, 3, 4)]
    known = [episode("tasks/pushing", 1), episode("tasks/grasping", 1), episode("tasks/reaching", 1), episode("tasks/placing", 1, PLACED)]
    found = learn_task("undoing", [*shown, (episode("tasks/reaching", 5), None, None)], ENGINE.knowledge, known=known)
    assert [w.split(" ")[0] for w in found.wrong] == [episode("tasks/reaching", 5).name]


# The package


def test_the_package_has_all_parts_and_its_rule_loads(tmp_path: Path) -> None:
    folder, *files = write_package(fetched(), "shelving", tmp_path / "made")
    assert {f.name for f in files} == {
        "__init__.py", "shelving.yaml", "test_shelving.py", "pyproject.toml", "README.md", "learned.html", "try_shelving.yaml",
    }  # fmt: skip
    engine = Engine(files=[folder / "cramlite_shelving" / "__init__.py"])
    assert "cram:Shelving" in engine.knowledge.tasks
    loaded = load_rules([folder / "cramlite_shelving" / "shelving.yaml"], engine.knowledge.predicates, engine.knowledge.taxonomy)
    assert set(loaded[0].roles) == set(fetched().roles)


def test_its_scenario_is_one_that_check_accepts(tmp_path: Path, run: Run) -> None:
    folder = write_package(fetched(), "shelving", tmp_path / "made")[0]
    checked = run("check", folder / "tests" / "try_shelving.yaml", "--plugin", folder / "cramlite_shelving" / "__init__.py")
    assert checked.code == 0 and "starts from the plan Shelving(" in checked.out, checked.err
    assert len(checked.out.splitlines()) == 1, "no doubt about its world"


def test_the_page_has_the_evidence() -> None:
    page = page_text(fetched())
    for evidence in fetched().evidence:
        assert all(text.replace(">", "&gt;") in page for _, text in evidence.texts)
        assert len(evidence.holds_in) == 3
    assert "Dropped as accidental" in page and "one more demonstration" in page


# What cannot be learned


def test_an_empty_interval_is_refused() -> None:
    with pytest.raises(UserError, match=r"nothing to learn from 2\.00 to 2\.01 s"):
        learn_task("shelving", [(episode("tasks/grasping", 1), 2.0, 2.01)], ENGINE.knowledge)


def test_contradictory_examples_are_named() -> None:
    same = episode("tasks/grasping", 1)
    with pytest.raises(UserError, match="contradictory"):
        learn_task("shelving", [(same, None, None)], ENGINE.knowledge, refused=[same])


def test_examples_in_which_other_things_begin_and_end_are_told_apart() -> None:
    let_go = episode("tasks/releasing", 1)
    held = next(e for e in let_go.events if e.type == "cram:GraspState")
    shown = [(episode("tasks/grasping", 1), None, None), (let_go, held.start + 0.1, None)]
    with pytest.raises(UserError, match=r"nothing in common.*grasping.*there begins .*grasps.*releasing.*there ends .*grasps"):
        learn_task("shelving", shown, ENGINE.knowledge)


def test_examples_in_which_something_moves_another_way_are_told_apart() -> None:
    pushed, carried = episode("tasks/pushing", 1), episode("tasks/transporting", 1)
    held = next(e for e in carried.events if e.type == "cram:GraspState")
    shown = [(pushed, None, None), (carried, held.start + 0.1, None)]
    with pytest.raises(UserError, match=r"contradictory: pushing.* shows .*Pushing.*; transporting.* shows .*"):
        learn_task("shelving", shown, ENGINE.knowledge)


def test_examples_of_one_task_with_another_beside_it_are_alike() -> None:
    shown = [(episode("tasks/pushing", seed), None, None) for seed in (1, 2)]
    assert learn_task("shelving", shown, ENGINE.knowledge).rule


def test_recordings_of_one_name_are_told_apart() -> None:
    one, other = episode("tasks/grasping", 1), episode("tasks/grasping", 2)
    assert one.name == other.name
    proposal = learn_task("shelving", [(one, None, None)], ENGINE.knowledge, known=[other])
    assert {e.span.timeline.episode.name for e in proposal.learned.examples} == {one.name}
    assert all(k.span.timeline.episode.name == f"{one.name} (2)" for k in proposal.learned.others)


def test_a_change_in_common_beside_others_is_learned() -> None:
    lifted = episode("tasks/picking_up", 1, "Grasping block, PickingUp block floor")
    shown = [(episode("tasks/grasping", 1), None, None), (lifted, None, None)]
    assert "grasps(" in str(learn_task("shelving", shown, ENGINE.knowledge).rule["post"])


# What nothing recorded tells


def test_a_change_that_must_be_measured_is_told() -> None:
    people = [episode("tasks/retracting", seed) for seed in (1, 2, 3)]
    shown = [(one, max(e.end for e in one.events if e.type == "cram:GraspState") + 0.3, None) for one in people]
    known = [episode("tasks/assuming_arm_pose", 1), episode("tasks/reaching", 1)]
    found = learn_task("leaving", shown, ENGINE.knowledge, known=known)
    assert found.learned.cast.measured and any(one in found.learned.literals for one in found.learned.cast.measured[0])


def test_standing_still_is_learned_though_nothing_begins_or_ends() -> None:
    shown = [(one := episode("tasks/no_op", seed), one.span[1] - 0.9, None) for seed in (1, 2, 3)]
    known = [episode("tasks/reaching", 1), episode("tasks/close_gripper_task", 1), episode("tasks/grasping", 1)]
    asked = learn_task("waiting", shown, ENGINE.knowledge, known=known).rule["run"]
    assert any(text in asked for text in ("not arm_moves()", "not moves(Gripper)", "not gripper_moves()"))


def test_a_name_that_exists_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="There is a plugin 'pouring' already"):
        write_package(fetched(), "pouring", tmp_path / "made")


def test_a_name_that_exists_is_refused_before_anything_is_read(run: Run, tmp_path: Path) -> None:
    found = run("learn", tmp_path / "nothing_there", "--task", "pouring")
    assert found.code == 2 and "There is a plugin 'pouring' already" in found.err
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").touch()
    found = run("learn", tmp_path / "nothing_there", "--task", "shelving", "--out", tmp_path / "full")
    assert found.code == 2 and "is not an empty folder" in found.err


@pytest.mark.parametrize(
    ("more", "said"),
    [(["--interval", "2"], "is no interval"), (["--interval", "1:2", "--interval", "2:3"], "1 episodes and 2 intervals")],
)
def test_bad_intervals_are_one_paragraph(run: Run, tmp_path: Path, more: list[str], said: str) -> None:
    found = run("learn", tmp_path, "--task", "shelving", *more)
    assert found.code == 2 and said in found.err and found.err.count("\n") == 1


# The solver


@st.composite
def problems(draw: st.DrawFn) -> Problem:
    """Few conditions, few groups."""
    count = draw(st.integers(1, 6))
    masks = st.integers(0, 2**count - 1)
    refuted = st.frozensets(masks, min_size=1, max_size=4).map(minimal)
    groups = draw(st.lists(st.builds(Group, refuted, st.sampled_from([3.0, 20.0])), max_size=5))
    wishes = draw(st.lists(st.builds(Wish, st.tuples(masks, masks), st.just(2.0)), max_size=2))
    needed = draw(st.lists(st.lists(st.integers(0, count - 1), min_size=1, max_size=3), max_size=2))
    bits = np.array(draw(st.lists(st.sampled_from([4.0, 7.0, 10.0]), min_size=count, max_size=count)))
    return Problem(bits, groups, wishes, needed, [])


def _bits(problem: Problem, chosen: tuple[int, ...]) -> float:
    """What a choice costs, by the definition."""
    taken = sum(1 << k for k in chosen)
    if any(not set(n) & set(chosen) for n in problem.needed):
        return float("inf")
    exceptions = sum(g.bits for g in problem.groups if any(not mask & taken for mask in g.refuted))
    wished = sum(w.bits for w in problem.wishes if all(mask & taken for mask in w.false))
    return float(problem.bits[list(chosen)].sum()) + exceptions + wished


@given(problems())
@examples(60)
def test_no_choice_is_shorter(problem: Problem) -> None:
    count = len(problem.bits)
    best = min(_bits(problem, c) for size in range(count + 1) for c in itertools.combinations(range(count), size))
    assert _bits(problem, shortest(problem).chosen) == pytest.approx(best)


def test_a_margin_is_bought_where_it_pays() -> None:
    narrow = [Group(frozenset({0b011}), 20.0, 4.0), Group(frozenset({0b111}), 20.0, 4.0)]
    problem = Problem(np.array([5.0, 6.0, 9.0]), narrow, [], [], [])
    assert widened(problem, (0,)) == (0, 1)  # 8 bits saved for 6
    assert widened(problem, (2,)) == (2,)


# Another demonstration


def test_another_demonstration_is_compared_step_by_step() -> None:
    knowledge = ENGINE.knowledge
    assert compared(fetched(), (episode("tasks/placing", 9, PLACED), None, None), knowledge) == ()
    held = "Grasping block, PickingUp block floor, PuttingDown block shelf"
    said = [str(d) for d in compared(fetched(), (episode("tasks/putting_down", 9, held), None, None), knowledge)]
    assert any(s.startswith("step missing: Releasing") for s in said)


def test_what_is_not_the_task_is_not_compared() -> None:
    with pytest.raises(UserError, match="the learned rule does not hold"):
        compared(fetched(), (episode("tasks/grasping", 1), None, None), ENGINE.knowledge)


# Trials


@pytest.mark.heavy
def test_a_robot_does_what_was_learned_and_the_rule_reads_it(tmp_path: Path) -> None:
    folder = write_package(fetched(), "shelving", tmp_path / "made")[0]
    scenario = read_scenario(find_scenario("tasks/placing"))
    (done,) = trials(fetched(), folder / "cramlite_shelving" / "__init__.py", scenario, range(11, 12))
    assert done.passed, done.reason


@pytest.mark.heavy
def test_a_run_that_lacks_a_change_is_not_what_was_learned(tmp_path: Path) -> None:
    folder = write_package(fetched(), "shelving", tmp_path / "made")[0]
    module = folder / "cramlite_shelving" / "__init__.py"
    text, begin = module.read_text(), 'Action(action.inside("3_'
    module.write_text(text[: text.index(begin)].rstrip() + "\n" + text[text.index("        )\n        yield") :])  # it is only lifted
    (done,) = trials(fetched(), module, read_scenario(find_scenario("tasks/placing")), range(11, 12))
    assert not done.passed and "supports(" in done.reason


def test_what_the_world_lacks_is_said(tmp_path: Path) -> None:
    folder = write_package(fetched(), "shelving", tmp_path / "made")[0]
    scenario = read_scenario(find_scenario("tasks/turning_on"))
    with pytest.raises(UserError, match="nothing for the role Patient: neither 'block' nor any"):
        next(trials(fetched(), folder / "cramlite_shelving" / "__init__.py", scenario, range(1, 2)))
