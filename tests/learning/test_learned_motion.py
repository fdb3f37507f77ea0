"""Motions and rests are learned from people, recognised, and done by a robot; what is not the motion is neither."""

from __future__ import annotations

import importlib.util
import re
import tempfile
from collections.abc import Callable
from functools import cache, partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from learned_motions import DONE, ROLES, job, solved
from motion_demonstrations import TOLD, WORLDS, WRONG, Shown_, of, shown, stir, wipe
from msgspec.structs import replace

from cramlite import Engine, Trace, read_scenario
from cramlite.engine.proof.line_origins import origins_of
from cramlite.engine.proof.proof import findings_of
from cramlite.interpretation.path_predicate import gone_through, headed, rests
from cramlite.interpretation.timeline import Timeline
from cramlite.learning.from_episodes import learn_task
from cramlite.learning.learner import covers
from cramlite.learning.package import page_text, write_package
from cramlite.learning.proposal import Proposal
from cramlite.learning.repeated import evenly, rounds, strokes
from cramlite.learning.shown_force import shown_force
from cramlite.learning.span import Span
from cramlite.learning.trial import trials
from cramlite.model import Episode, Rollout
from cramlite.model.shown_path import length
from cramlite.plugin import Candidate, UserError
from cramlite.testing import check_plugin

ENGINE = Engine()
TASKS = [*DONE]


@cache
def person(motion: str, seed: int, wrong: str = "") -> Shown_:
    with tempfile.TemporaryDirectory() as folder:
        scripts = {motion: WRONG[motion][wrong]} if wrong else None
        found = shown(ENGINE, motion, seed, Path(folder), scripts)
    assert not found.failure
    return found


@cache
def learned(motion: str) -> Proposal:
    return learn_task(motion, [(p.episode, p.start, p.end) for p in (person(motion, s) for s in (1, 2, 3))], ENGINE.knowledge)


def read(motion: str, one: Shown_) -> bool:
    span = Span(Timeline(one.episode, ENGINE.knowledge.taxonomy), one.start, one.end)
    found = covers(learned(motion).learned, span)
    return any(dict(zip(learned(motion).roles, f, strict=True)) == dict(zip(ROLES, TOLD[motion], strict=False)) for f in found)


# The periodic part


def test_rounds_are_found_between_a_way_in_and_a_way_out() -> None:
    angles = np.linspace(0, 2 * np.pi * 3.5, 400)
    ring = np.stack([0.04 * np.cos(angles), 0.04 * np.sin(angles), np.zeros(400)], axis=1)
    way_in, out = np.linspace((0.3, 0.1, 0.1), ring[0], 100), np.linspace(ring[-1], (-0.1, 0.0, 0.2), 100)
    points = np.concatenate([way_in, ring, out])
    found = rounds(evenly(np.arange(len(points)) * 0.02, points)[1])
    assert found is not None and found.count == pytest.approx(3.5, abs=0.25)
    assert np.linalg.norm(found.mean[:, :2], axis=1) == pytest.approx(0.04, abs=0.006)


def test_one_round_a_line_and_standing_still_are_not_periodic() -> None:
    times, angles = np.arange(300) * 0.02, np.linspace(0, 2 * np.pi * 1.3, 300)
    ring = np.stack([0.04 * np.cos(angles), 0.04 * np.sin(angles), np.zeros(300)], axis=1)
    assert rounds(evenly(times, ring)[1]) is None
    assert rounds(evenly(times, np.linspace((0, 0, 0), (0.4, 0.2, 0.1), 300))[1]) is None
    still = np.random.default_rng(0).normal(0, 0.0005, (300, 3))
    assert rounds(evenly(times, still)[1]) is None


def test_strokes_are_what_touches_between_ways_back() -> None:
    there, back = np.linspace((0.0, 0.0, 0.0), (0.2, 0.0, 0.0), 60), np.linspace((0.2, 0.0, 0.05), (0.0, 0.0, 0.05), 60)
    points = evenly(np.arange(360) * 0.02, np.concatenate([there, back] * 3))[1]
    found = strokes(points, points[:, 2] < 0.005, 0.06)
    assert len(found) == 3 and all(length(points[a : b + 1]) == pytest.approx(0.2, abs=0.03) for a, b in found)
    lifted = np.where(abs(points[:, 0] - 0.1) < 0.01, 0.003, 0.0) + points[:, 2]
    assert len(strokes(points, lifted < 0.002, 0.06)) == 3, "what is lifted on a short way goes on"
    assert strokes(points, np.zeros(len(points), dtype=bool), 0.06) == []


def test_a_rest_is_within_a_place() -> None:
    one = person("weighing", 1)
    found = list(rests(one.episode, one.episode.effector or "", (one.start, one.end)))
    assert found[0][0] == pytest.approx(one.start, abs=0.03) and found[-1][1] == one.end
    assert all(a[1] == b[0] for a, b in pairwise(found)), "one begins where the last one ended"
    assert found[-1][1] - found[-1][0] == pytest.approx(2.5, abs=0.8)


# The motion, its rule and its package


@pytest.mark.heavy
@pytest.mark.parametrize(("motion", "closed", "touching"), [("stirring", 1, 0), ("wiping_lines", 0, 1), ("sweeping", 0, 1)])
def test_a_motion_is_told_about_the_thing_about_which_people_agree(motion: str, closed: bool, touching: bool) -> None:
    proposal = learned(motion)
    assert proposal.moving is not None
    shared = proposal.moving[0]
    assert shared.fillers == (TOLD[motion][:2],) * 3 and (shared.path.closed, shared.path.touching) == (closed, touching)
    assert shared.spread < 0.006 and proposal.steps == ()
    assert f"follows_{motion}(Patient, Relatum)" in proposal.rule["run"]
    assert (shared.path.heading is None) == (motion != "sweeping"), "people hold a brush across, and anything else as they like"


@pytest.mark.heavy
def test_strokes_are_counted_and_what_they_are_for_is_in_the_rule() -> None:
    proposal = learned("sweeping")
    assert proposal.moving is not None
    path, counts = proposal.moving[0].path, proposal.moving[0].counts
    assert min(counts) >= 2 and path.times == max(counts) and path.least < 1.0, "how often is up to the grains"
    assert path.heading == pytest.approx(0.0, abs=0.05)
    assert "not contains(Destination, _)" in proposal.rule["pre"] and "contains(Destination, _)" in proposal.rule["post"]


@pytest.mark.heavy
@pytest.mark.parametrize("motion", TASKS)
def test_unseen_people_are_recognised(motion: str) -> None:
    assert all(read(motion, person(motion, seed)) for seed in (4, 5))


@pytest.mark.heavy
@pytest.mark.parametrize(("motion", "wrong"), [(m, w) for m in TASKS for w in WRONG[m]])
def test_people_who_do_something_else_are_not(motion: str, wrong: str) -> None:
    assert not read(motion, person(motion, 4, wrong))


@pytest.mark.heavy
def test_a_motion_is_no_other_motion() -> None:
    moving = learned("stirring").moving
    assert moving is not None
    one = person("wiping_lines", 4)
    assert gone_through(moving[0].path, one.episode, *TOLD["wiping_lines"], (one.start, one.end)) == 0.0


def wiping_with(change: Callable[[Episode], Episode]) -> Proposal:
    """Learned from people whose recordings were changed."""
    return learn_task("wiping_lines", [(change(p.episode), p.start, p.end) for p in (person("wiping_lines", s) for s in (1, 2, 3))],
                      ENGINE.knowledge)  # fmt: skip


def times_as_hard(factor: float, episode: Episode) -> Episode:
    return replace(episode, extras={**episode.extras, "wrench": factor * episode.extras["wrench"]})


def unfelt(episode: Episode) -> Episode:
    return replace(episode, extras={k: v for k, v in episode.extras.items() if k != "wrench"})


def pressed(rollout: Rollout, start: float, end: float) -> float:
    """Median of the force between sponge and board at the samples of a run at which they touch [N]."""
    inside = (touches for t, touches in zip(rollout.times, rollout.touches, strict=True) if start <= t <= end)
    each = (sum(t.pressed for t in touches if {t.a, t.b} == {"sponge", "board"}) for touches in inside)
    return float(np.median([f for f in each if f > 0.0]))


@pytest.mark.heavy
@pytest.mark.parametrize("deep", [0.002, 0.004])
def test_the_force_is_that_of_the_contact(deep: float, tmp_path: Path) -> None:
    harder = {"wiping_lines": partial(wipe, deep=deep)}
    one = person("wiping_lines", 3) if deep == 0.002 else shown(ENGINE, "wiping_lines", 3, tmp_path, harder)
    span = Span(Timeline(one.episode, ENGINE.knowledge.taxonomy), one.start, one.end)
    force = shown_force([span], [("sponge", "board")])
    assert force is not None and force.press_n == pytest.approx(pressed(one.rollout, one.start, one.end), abs=2.0)


@pytest.mark.heavy
def test_twice_the_force_is_twice_the_press_and_says_whose_it_is(tmp_path: Path) -> None:
    once, twice = learned("wiping_lines"), wiping_with(partial(times_as_hard, 2.0))
    assert once.moving is not None and twice.moving is not None and once.moving[0].force is not None and twice.moving[0].force is not None
    assert twice.moving[0].force.press_n == pytest.approx(2 * once.moving[0].force.press_n, abs=0.2)
    assert all(str(e.span) + ": " in page_text(twice) for e in twice.learned.examples)
    assert "Programs stop at 60 N" in page_text(twice) and "Programs stop at 60 N" not in page_text(once)
    folder, *_ = write_package(twice, "wiping_lines", tmp_path / "made")
    trace = Trace()
    hard = Engine(files=[folder / "cramlite_wiping_lines" / "__init__.py"])
    assert solved(hard, "wiping_lines", "ur5e", 101, tmp_path, trace) is None, "no program presses so hard"
    assert any("its force limit of 79 N is not in 0 .. 60 N, the program's" in e.reason for e in trace.entries)


@pytest.mark.heavy
def test_who_records_no_force_leaves_the_default_and_the_page_says_so(tmp_path: Path) -> None:
    proposal = wiping_with(unfelt)
    module = write_package(proposal, "wiping_lines", tmp_path / "made")[0] / "cramlite_wiping_lines" / "__init__.py"
    text = module.read_text(encoding="utf-8")
    assert 'Parameter("press_n", 12.0, ' in text and 'Parameter("force_limit_n", 25.0, ' in text
    assert "No example says with what force it presses: it is 12 N by default" in page_text(proposal)


@pytest.mark.heavy
def test_a_robot_presses_as_people_do() -> None:
    moving, candidate = learned("wiping_lines").moving, program("wiping_lines")
    assert moving is not None and moving[0].force is not None and candidate.rollout is not None
    assert pressed(candidate.rollout, 0.0, np.inf) == pytest.approx(moving[0].force.press_n, rel=0.1)


@pytest.mark.heavy
def test_a_rest_at_the_end_comes_behind_known_tasks() -> None:
    proposal = learned("weighing")
    assert proposal.rest is not None and proposal.rest.least_s < 2.0 < proposal.rest.duration_s
    assert [s.task for s in proposal.steps] == ["soma:PuttingDown", "soma:Releasing", "soma:Retracting"]
    assert "rests_weighing()" in proposal.rule["run"] and "supports(Relatum, Patient)" in proposal.rule["post"]


@pytest.mark.heavy
def test_a_rest_that_one_of_five_leaves_out_is_no_part_of_the_task() -> None:
    proposal = _five("weighing")
    assert proposal.wrong == () and proposal.rest is None and proposal.done and proposal.rule["run"] == []


def _five(motion: str) -> Proposal:
    """Learned from four people, and one who shows something else."""
    people = [person(motion, seed) for seed in (1, 2, 3, 4)] + [person(motion, 6, next(iter(WRONG[motion])))]
    return learn_task(motion, [(p.episode, p.start, p.end) for p in people], ENGINE.knowledge)


@pytest.mark.heavy
@pytest.mark.parametrize("motion", ["stirring", "wiping_lines"])
def test_one_of_five_who_shows_something_else_is_named(motion: str) -> None:
    proposal = _five(motion)
    assert [w.split(" ")[0] for w in proposal.wrong] == [f"{motion}_6"]
    assert proposal.told is not None and proposal.done


@pytest.mark.heavy
def test_those_who_were_refused_say_from_where_it_counts(tmp_path: Path) -> None:
    people = [(p.episode, p.start, p.end) for p in (person("stirring", s) for s in (1, 2, 3))]
    twice = shown(ENGINE, "stirring", 4, tmp_path, {"stirring": partial(stir, rounds=2)})
    moving, before = learn_task("stirring", people, ENGINE.knowledge, refused=[twice.episode]).moving, learned("stirring").moving
    assert moving is not None and before is not None
    assert before[0].path.least == pytest.approx(0.75 * 3.09, abs=0.06)
    assert moving[0].path.least == pytest.approx((2.0 + 3.09) / 2, abs=0.1)


@pytest.mark.heavy
def test_those_who_show_different_things_are_contradictory() -> None:
    people = [person("stirring", 1), person("stirring", 2, "kept still"), person("stirring", 3, "above the bowl")]
    with pytest.raises(UserError, match=r"contradictory: stirring_1 .* shows .*; stirring_2 .* shows .*Transporting"):
        learn_task("stirring", [(p.episode, p.start, p.end) for p in people], ENGINE.knowledge)


@pytest.mark.heavy
@pytest.mark.parametrize("motion", TASKS)
def test_the_package_keeps_the_contract_and_its_text_is_the_same_again(motion: str, tmp_path: Path) -> None:
    folder, *_ = write_package(learned(motion), motion, tmp_path / "one")
    module = folder / f"cramlite_{motion}" / "__init__.py"
    again = learn_task(motion, [(p.episode, p.start, p.end) for p in (person(motion, s) for s in (1, 2, 3))], Engine().knowledge)
    other = write_package(again, motion, tmp_path / "two")[0]
    assert module.read_bytes() == (other / f"cramlite_{motion}" / "__init__.py").read_bytes()
    spec = importlib.util.spec_from_file_location(f"cramlite_{motion}", module)
    assert spec is not None and spec.loader is not None
    plugin = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(plugin)
    check_plugin(plugin)
    tasks = read_scenario(folder / "tests" / f"try_{motion}.yaml").spec.tasks or ()
    first = ["Screwing"] if motion == "screwing" else ["soma:Grasping", "soma:PickingUp"]
    assert [str(t.task) for t in tasks][:2] == first, "it takes the tool from where it stands"  # type: ignore[union-attr]
    said = {"weighing": "At the end the hand rests for", "screwing": "Rotation vector of Patient in its own frame"}
    assert said.get(motion, "Path of the bottom centre of Patient") in page_text(learned(motion))


# A robot does it


@cache
def engine_of(motion: str) -> Engine:
    folder = Path(tempfile.mkdtemp())
    return Engine(files=[write_package(learned(motion), motion, folder / "made")[0] / f"cramlite_{motion}" / "__init__.py"])


@cache
def program(motion: str) -> Candidate:
    """The first program of a UR5e in a world that nobody showed."""
    with tempfile.TemporaryDirectory() as folder:
        solution = solved(engine_of(motion), motion, "ur5e", 101, Path(folder), Trace())
    assert solution is not None and solution.verdict.passed
    return solution.candidate


def objections(motion: str, text: str) -> dict[str, str]:
    """Validator -> its reason against an edited text."""
    candidate, knowledge = program(motion), engine_of(motion).knowledge
    assert candidate.code is not None
    rollout = knowledge.simulator.execute(text, candidate.world, knowledge.robots, mount=candidate.program.robot, seed=0)
    episode = knowledge.episodes.detect(rollout, candidate.program.name)
    code = replace(candidate.code, text=text, origins=dict(origins_of(text, candidate.code).of))
    edited = replace(candidate, code=code, proven=candidate.code, rollout=rollout, episode=episode)
    return {f.validator: f.reason for f in findings_of(edited, knowledge, rollout=True) if not f.passed}


@pytest.mark.heavy
@pytest.mark.parametrize("motion", TASKS)
def test_a_robot_does_it_where_nobody_showed_it(motion: str) -> None:
    candidate = program(motion)
    assert candidate.code is not None and candidate.episode is not None
    assert DONE[motion](candidate, *of(motion, candidate.world))
    assert objections(motion, candidate.code.text) == {}, "its text as it is"


@pytest.mark.heavy
def test_a_brush_that_stands_turned_is_held_across_the_stroke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    turned = WORLDS["sweeping"].replace("position: [0.43, 0.29, 0.216]", "position: [0.43, 0.29, 0.216], yaw: 70 deg")
    assert turned != WORLDS["sweeping"]
    monkeypatch.setitem(WORLDS, "sweeping", turned)  # type: ignore[arg-type]
    solution = solved(engine_of("sweeping"), "sweeping", "ur5e", 101, tmp_path, Trace())
    assert solution is not None and solution.candidate.episode is not None
    world, episode = solution.candidate.world, solution.candidate.episode
    assert DONE["sweeping"](solution.candidate, world.thing("brush"), world.thing("board"))
    strokes_at = [e.start + 1.0 for e in episode.of("state") if {"brush", "board"} <= set(e.roles.values()) and e.end - e.start > 2.0]
    angles = headed(episode, "brush", "board", np.array(strokes_at))
    assert len(angles) >= 2 and abs(np.sin(angles)).max() < np.sin(0.1), "half a turn is the same to a box"


def edited(motion: str, *changes: tuple[str, str]) -> str:
    code = program(motion).code
    assert code is not None
    text = code.text
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


@pytest.mark.heavy
def test_one_round_is_not_stirring() -> None:
    said = objections("stirring", edited("stirring", ("round_1 < 3", "round_1 < 1")))
    assert "follows_stirring(Patient, Relatum)" in said["task_rules"]


@pytest.mark.heavy
def test_a_pattern_of_which_a_line_is_left_out_is_not_wiped() -> None:
    last = [f"    movel(wiping_lines_3_follow_pose_{k}, a=0.25, v=0.02)" for k in range(7, 13)]
    said = objections("wiping_lines", edited("wiping_lines", *((line, line.replace("movel", "# movel")) for line in last)))
    assert "follows_wiping_lines(Patient, Relatum)" in said["task_rules"]


@pytest.mark.heavy
def test_grains_that_are_left_on_the_board_are_not_swept() -> None:
    code = program("sweeping").code
    assert code is not None
    ends = re.compile(r"(_follow(?:_2)?_pose(?:_2)? = p\[[-.\d]+, )([-.\d]+)")
    text, count = ends.subn(lambda m: f"{m[1]}{float(m[2]) + 0.06:.6f}", code.text)
    assert count >= 4
    said = objections("sweeping", text)
    assert "contains(Destination, _)" in said["task_rules"] or "follows_sweeping(Patient, Relatum)" in said["task_rules"]


@pytest.mark.heavy
def test_who_does_not_wait_has_not_weighed() -> None:
    code = program("weighing").code
    assert code is not None
    waits = code.text[code.text.index("# 3.Weighing/rest") :].splitlines()[1]
    assert "sleep(" in waits
    said = objections("weighing", edited("weighing", (waits, "  # taken out")))
    assert "rests_weighing()" in said["task_rules"]


@pytest.mark.heavy
def test_a_trial_does_what_comes_before_and_reads_the_task_alone(tmp_path: Path) -> None:
    folder = write_package(learned("weighing"), "weighing", tmp_path / "made")[0]
    module, scenario = folder / "cramlite_weighing" / "__init__.py", read_scenario(job("weighing", "ur5e", tmp_path))
    (done,) = trials(learned("weighing"), module, scenario, range(102, 103))
    assert done.passed, done.reason
    short = module.read_text().replace('Parameter("rest_s", ', 'Parameter("rest_s", 0.1 * ')
    module.write_text(short)
    (done,) = trials(learned("weighing"), module, scenario, range(102, 103))
    assert not done.passed and "rests_weighing()" in done.reason
