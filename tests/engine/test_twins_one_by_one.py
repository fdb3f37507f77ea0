"""What a verdict about twins is made of: each run's number, seed and draws, in order, and where the runs end.

The processes are replaced by a list of what they would answer; what succeeded is a real run, judged by the real validators.
"""

from __future__ import annotations

import math
import time
from collections.abc import Generator, Iterator
from contextlib import closing
from typing import Any

import pytest
from helpers.edited import engine, proven
from helpers.written_runs import Says, Written, knowing
from msgspec.structs import replace

from cramlite import find_scenario, read_scenario
from cramlite.base.pulse import ASKED, Stopped, pulse
from cramlite.engine.proof.executor_group import ExecutorGroup, group_of, processes_here
from cramlite.engine.proof.twin_proof import doubt, over, twin_seed
from cramlite.engine.setting import Setting
from cramlite.model import (
    Camera,
    ErrorModel,
    Estimate,
    Finding,
    Pose,
    PoseError,
    ProofDoubts,
    RobotMount,
    Rollout,
    Verdict,
    World,
)
from cramlite.model.remedy import Remedy
from cramlite.model.twins.error_model import NO_ERRORS
from cramlite.perception.active_perception import Look, Picture, _with, ask
from cramlite.perception.query import ObjectQuery
from cramlite.plugin import Candidate
from cramlite.plugin.selection import INSTALLED
from cramlite.scenario.twin import draw_twin
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.locations.viewpoints import looking_at
from cramlite_plugins.objects.products_and_fixtures import hanger
from cramlite_plugins.robots.ur5e import UR5E

NOMINAL = Verdict((Finding("nominal", True, "it was accepted"),))
TWO = replace(NO_ERRORS, friction=0.5, mass=0.2)
"""Two sources of error."""


SEEDS = [133627082, 488915954]
BELIEVED = engine().setting(read_scenario(find_scenario("tasks/picking_up")))


class Answers(ExecutorGroup):
    """Group without processes: each run ends as it was said; True for the run that was accepted, a clause for one that did not end."""

    def __init__(self, candidate: Candidate, *ends: bool | str) -> None:
        super().__init__(INSTALLED, 1)
        self.candidate, self.ends, self.asked = candidate, list(ends), list[tuple[World, int]]()

    def runs(self, text: str, places: Iterator[tuple[World, int]]) -> Generator[Rollout | str]:
        """Answer for one place after another."""
        assert self.candidate.rollout is not None
        for place in places:
            self.asked.append(place)
            end = self.ends.pop(0)
            if end is False:  # the program was not run at all
                yield replace(self.candidate.rollout, outcome="halted", reason="it hangs")
            else:
                yield end if isinstance(end, str) else self.candidate.rollout


def setting(doubts: ProofDoubts) -> Setting:
    return replace(BELIEVED, doubts=doubts)


def doubted(*ends: bool | str, twins: int = 3, at_least: float = 0.5, errors: ErrorModel = TWO) -> tuple[Verdict, Answers, list[str]]:
    """The verdict, who was asked, and what was said meanwhile."""
    candidate, said = proven("picking_up"), list[str]()
    group = Answers(candidate, *ends)
    found = doubt(candidate, NOMINAL, setting(ProofDoubts(twins, at_least, errors)), engine().knowledge, group, said.append, 0.0)
    assert found is not None
    return found, group, said


def text() -> str:
    code = proven("picking_up").code
    assert code is not None
    return code.text


def test_runs_that_succeed_end_as_soon_as_they_are_enough() -> None:
    found, group, said = doubted(True, True, True, at_least=0.5)
    assert found.passed and found.twins is not None and (found.twins.succeeded, found.twins.ran) == (2, 2)
    spared = "2 not run: the verdict is certain"
    assert len(group.asked) == 1 and said == ["twin 1 of 3: succeeded", f"twins: 2 of 2, interval .34 to 1.00; {spared}"]
    (finding,) = found.findings[1:]
    assert (finding.validator, finding.passed, finding.value, finding.limit, finding.origin) == ("twins", True, 1.0, 0.5, "")


def test_each_run_has_its_number_its_seed_and_what_was_drawn_for_it() -> None:
    found, group, said = doubted(True, "it fell over", True, at_least=0.75)
    assert found.passed and found.twins is not None
    runs = found.twins.twins
    assert [(r.number, r.succeeded, r.reason) for r in runs] == [(1, True, ""), (2, False, "execution: it fell over"), (3, True, "")]
    assert [r.seed for r in runs] == [seed for _, seed in group.asked] == [twin_seed(0, text(), k) for k in (1, 2, 3)]
    twins = [draw_twin(BELIEVED.world, BELIEVED.relations, BELIEVED.robot, TWO, r.seed, None) for r in runs]
    assert [r.draws for r in runs] == [t.draws for t in twins] and [world for world, _ in group.asked] == [t.world for t in twins]
    assert runs[0].draws != runs[1].draws != runs[2].draws
    assert "twin 2 of 3: execution: it fell over" in said
    assert found.findings[-1].value == 0.75


def test_a_run_that_a_validator_objects_to_failed_where_the_validator_says() -> None:
    found, _, _ = doubted(False, True, True, at_least=0.75)
    assert found.passed and found.twins is not None
    first = found.twins.twins[0]
    assert not first.succeeded and first.reason.startswith("execution: halted at line") and first.origin != ""
    assert found.findings[-1].origin == first.origin


@pytest.mark.parametrize(("alone", "cause"), [(("it slipped again",), "friction"), ((True, "it fell"), "mass")])
def test_of_the_first_that_failed_sources_of_error_are_tried_by_themselves_until_one_breaks_it(alone: tuple[Any, ...], cause: str) -> None:
    """Friction is tried before mass; then the runs end."""
    found, group, said = doubted(True, "it slipped", *alone, at_least=1.0)
    assert not found.passed and found.twins is not None
    assert [r.number for r in found.twins.twins] == [1, 2]
    assert [(r.causes, r.looked_for) for r in found.twins.twins] == [((), False), ((cause,), True)]
    assert "twin 2: looking for the error that broke it" in said and len(group.asked) == 2 + len(alone)
    seeds = [seed for _, seed in group.asked]
    assert seeds[2:] == [seeds[1]] * len(alone)
    assert not found.findings[-1].passed and found.findings[-1].value == pytest.approx(2 / 3)


@pytest.mark.parametrize(("wrong", "passes"), [(1, True), (9, False)])
def test_what_to_try_is_told_where_too_many_runs_failed(wrong: int, passes: bool) -> None:
    candidate, remedy, left = proven("picking_up"), Remedy("far", "put it nearer"), [False] * wrong
    validator = Says("bad", lambda _: [Finding("bad", left.pop() if left else True, "it is far", remedy=remedy)])
    group, doubts = Answers(candidate, *[True] * 12), ProofDoubts(3, 0.5, TWO)
    found = doubt(candidate, NOMINAL, setting(doubts), knowing(Written(), [validator]), group, lambda _: None, 0.0)
    assert found is not None and found.passed is passes and found.twins is not None and found.twins.failed
    assert found.findings[-1].remedy == (None if passes else remedy)


def test_without_doubts_there_is_nothing_to_explain_but_all_of_them_may_break_it_together() -> None:
    found, group, _ = doubted("it fell", True, True, at_least=1.0, twins=1)
    assert found.twins is not None and found.twins.twins[0].causes == () and found.twins.twins[0].looked_for
    assert len(group.asked) == 3 and group.ends == []
    found, group, _ = doubted("it fell", at_least=1.0, twins=1, errors=NO_ERRORS)
    assert found.twins is not None and found.twins.twins[0].looked_for and len(group.asked) == 1


def test_the_camera_is_tried_where_one_looked() -> None:
    """Of three sources the camera's is left out where poses are known."""
    errors = replace(TWO, hand_eye=PoseError(0.003))
    _, group, _ = doubted("it fell", True, True, at_least=1.0, twins=1, errors=errors)
    assert len(group.asked) == 3
    candidate, answers = proven("picking_up"), Answers(proven("picking_up"), "it fell", True, True, "beside it")
    seen = replace(setting(ProofDoubts(1, 1.0, errors)), look=looked(Camera(Pose((1.0, 0.0, 1.0)))))
    found = doubt(candidate, NOMINAL, seen, engine().knowledge, answers, lambda _: None, 0.0)
    assert found is not None and found.twins is not None and found.twins.twins[0].causes == ("hand-eye",)


def test_who_stops_it_is_asked_before_each_run() -> None:
    group, doubts = Answers(proven("picking_up"), True, True), setting(ProofDoubts(3, 1.0, TWO))
    stopped = list[bool]()

    def said(text: str) -> None:
        stopped.append(True)
        time.sleep(2 * ASKED)

    with pytest.raises(Stopped), pulse(lambda: bool(stopped)):
        doubt(proven("picking_up"), NOMINAL, doubts, engine().knowledge, group, said, 0.0)
    assert len(group.asked) == 1


def test_when_the_runs_will_be_over_is_told_from_the_nominal_run_then_from_those_that_are_done() -> None:
    now = time.monotonic()
    assert over(6, 0, now, 6000.0) - now == pytest.approx(6 * 6000.0 / processes_here(), abs=60.0)
    for done, left in ((1, 5000.0), (2, 2000.0), (4, 500.0), (6, 0.0)):
        assert over(6, done, now - 1000.0, 6000.0) - now == pytest.approx(left, abs=60.0)


def test_whoever_waits_is_told_when_the_runs_will_be_over() -> None:
    told, doubts = list[float](), setting(ProofDoubts(3, 0.5, TWO))

    class Watched(Answers):
        """Group that notes what is told before each run."""

        def runs(self, text: str, places: Iterator[tuple[World, int]]) -> Generator[Rollout | str]:
            """Note it, then answer."""
            for answer in super().runs(text, places):
                assert its.work is not None and its.work.ends is not None
                told.append(its.work.ends - time.monotonic())
                yield answer

    with pulse(lambda: False) as its:
        doubt(proven("picking_up"), NOMINAL, doubts, engine().knowledge, Watched(proven("picking_up"), True), lambda _: None, 8000.0)
    assert told == [pytest.approx(3 * 8000.0 / processes_here(), abs=60.0)]


def test_what_does_not_run_here_is_judged_as_it_was() -> None:
    candidate, group = proven("picking_up"), Answers(proven("picking_up"))
    for unproven in (replace(candidate, rollout=None), replace(candidate, code=None)):
        assert doubt(unproven, NOMINAL, setting(ProofDoubts()), engine().knowledge, group, lambda _: None, 0.0) is NOMINAL


def test_processes_are_started_when_they_are_needed_and_no_more_than_there_are_twins() -> None:
    with closing(group_of(engine().knowledge)) as group:
        assert len(group._all) == processes_here() and all(one.pid is None for one in group._all)
        group.start(1)
        assert sum(one.pid is not None for one in group._all) == 1
        group.start(1000)
        assert all(one.pid is not None for one in group._all)


def looked(camera: Camera | None) -> Look:
    nothing: Any = None
    pictures = (Picture(nothing, camera, ()),) if camera else ()
    return Look(pictures, World(()), (), {"block": nothing}, World(()))


def test_no_more_worlds_are_drawn_than_there_are_twins() -> None:
    drawn, candidate = list[int](), proven("picking_up")

    class Ahead(Answers):
        """Group that asks for every place before the first run."""

        def runs(self, text: str, places: Iterator[tuple[World, int]]) -> Generator[Rollout | str]:
            """Count the places, then answer."""
            every = list(places)
            drawn.append(len(every))
            return super().runs(text, iter(every))

    group = Ahead(candidate, True, True, True)
    assert doubt(candidate, NOMINAL, setting(ProofDoubts(3, 1.0, TWO)), engine().knowledge, group, lambda _: None, 0.0) is not None
    assert drawn == [3]


def test_it_is_the_first_that_failed_which_is_explained() -> None:
    found, _, said = doubted("it fell", "it slipped", True, True, twins=4, at_least=0.8)
    assert found.twins is not None and [r.looked_for for r in found.twins.twins] == [True, False]
    assert "twin 1: looking for the error that broke it" in said


def test_a_programs_twins_are_the_same_ones_whenever_they_are_drawn() -> None:
    assert [twin_seed(0, "text", k) for k in (1, 2)] == SEEDS


def test_what_a_camera_saw_is_as_uncertain_as_where_the_camera_is() -> None:
    """A turn of the camera moves what is far more than what is near; a calibrated camera adds nothing."""
    there = BELIEVED.world.thing("block").pose

    def sigma(height: float, hand_eye: PoseError) -> float:
        camera = Camera(Pose((there.position[0], there.position[1], there.position[2] + height)))
        look = replace(looked(camera), estimates={"block": Estimate(there, 0.002)})
        doubts = ProofDoubts(errors=replace(NO_ERRORS, hand_eye=hand_eye, scale=2.0))
        return replace(BELIEVED, look=look, doubts=doubts).belief().poses["block"].sigma

    assert sigma(0.5, PoseError()) == 0.002
    assert sigma(0.5, PoseError(0.003)) == pytest.approx(math.hypot(0.002, 2 * 0.003 / math.sqrt(5)))
    assert sigma(1.0, PoseError(0.0, 0.01)) == pytest.approx(math.hypot(0.002, 2 * 0.01 / math.sqrt(5)))
    assert sigma(1.0, PoseError(0.003, 0.01)) > sigma(0.5, PoseError(0.003, 0.01)) > sigma(0.5, PoseError(0.003))


@pytest.mark.parametrize(("off", "sigma"), [(0.002, 0.002), (0.1, 2 * 0.002 / math.sqrt(5))])
def test_a_fixture_that_no_picture_locates_is_as_uncertain_as_the_map(off: float, sigma: float) -> None:
    real = hanger("hook", Pose((0.87, 0.0, 0.45), (0, 0, 0, 1)))
    hook = replace(real, pose=Pose((0.87, off, 0.45), (0, 0, 0, 1)))
    eye = Camera(looking_at((0.4, -0.25, 0.62), (0.8, 0, 0.42)))
    view = engine().knowledge.simulator.look(World((real,)), {}, eye, seed=0)
    said = ask(ObjectQuery(wanted=("refined",)), view, (hook,), engine().knowledge)
    before = replace(looked(eye), pictures=(), estimates={})
    seen = _with(before, Picture(view, eye, (hook,), perceived=said), engine().knowledge)
    doubts = ProofDoubts(errors=replace(NO_ERRORS, pose=PoseError(0.002), scale=2.0))
    found = replace(BELIEVED, world=World((hook,), BELIEVED.world.robots), look=seen, doubts=doubts).belief().poses["hook"]
    assert found.sigma == pytest.approx(sigma), found.source
    assert ("not located by the camera: 0 points on its peg" in found.source) == (off > 0.01) == ("hook" in seen.unlocated)


def test_where_the_camera_was() -> None:
    """One that is fixed is where it is; one on a flange is where the arm was when it looked."""
    assert BELIEVED.sight is None and replace(BELIEVED, look=looked(None)).sight is None
    at = Pose((0.1, 0.2, 0.3), (0.5, 0.5, 0.5, 0.5))
    fixed = replace(BELIEVED, look=looked(Camera(at))).sight
    assert fixed is not None and (fixed.camera, fixed.things) == (at, frozenset({"block"}))
    elsewhere = RobotMount("other", "ur5e", Pose((1.0, 1.0, 0.0)))
    two = replace(BELIEVED, world=replace(BELIEVED.world, robots=(*BELIEVED.world.robots, elsewhere)))
    for joints in ((0.1, -1.2, 1.3, -1.4, -1.5, 0.6), ()):
        sight = replace(two, look=looked(Camera(at, "arm", joints))).sight
        flange = forward(UR5E, joints or UR5E.home) * UR5E.gripper.tcp.inverse()
        assert sight is not None and sight.camera.distance(flange * at) == pytest.approx((0.0, 0.0), abs=1e-6)
