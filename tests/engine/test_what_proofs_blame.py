"""Which choices a failed proof blames, and which of them later: of a plan that is grounded in a scenario, with findings of our own."""

from __future__ import annotations

import pytest
from conftest import ROOT

from cramlite import Engine, Trace, read_scenario
from cramlite.engine.proof.proof import conflict_of
from cramlite.engine.search_in_setting import search_in
from cramlite.model import Verdict
from cramlite.planning.refutation import Later
from cramlite.planning.search.state import State
from cramlite.plugin import Finding

LED_PAST = {"2.PickingUp/up", "3.Placing/Retracting/away", "home"}


@pytest.fixture(scope="module")
def state() -> State:
    """Grasp, pick up, place on a shelf, park."""
    scenario, engine = read_scenario(ROOT / "scenarios" / "place_on_shelf.yaml"), Engine()
    setting = engine.setting(scenario, twins=0)
    plan = next(iter(engine.candidates(scenario, setting=setting, trace=Trace())))
    search = search_in(plan.setting, plan.knowledge, plan.budget, plan.trace)
    return next(search.solve(plan.setting.start(plan.plan)))


def blamed(state: State, *findings: Finding) -> tuple[set[str], set[str]]:
    """Places that are blamed at once, and later."""
    conflict = conflict_of(Verdict(findings), state)
    places = {name for name in state.bindings if name in LED_PAST or name.startswith(("grasp(", "on("))}
    return {n for n in places if n in conflict}, {n for n in places if Later(n) in conflict}


def test_what_slipped_is_grasped_otherwise_before_it_is_lifted_less_high(state: State) -> None:
    slip = Finding("slip", False, "it moved 21 mm in the hand", origin="2.PickingUp", things=True)
    assert blamed(state, slip) == ({"grasp(block)"}, {"2.PickingUp/up"})


def test_what_does_not_stay_is_put_elsewhere_before_the_hand_goes_back_less_far(state: State) -> None:
    gone = Finding("end", False, "it lies beside the shelf", things=True)
    assert blamed(state, gone) == ({"grasp(block)", "on(shelf)"}, LED_PAST)


def test_another_objection_in_the_same_task_does_not_bring_the_lift_forward(state: State) -> None:
    """Both have to go, and the lift is not known to change the first."""
    slip = Finding("slip", False, "it moved 21 mm in the hand", origin="2.PickingUp", things=True)
    rule = Finding("rules", False, "after 2.PickingUp the hand holds nothing", origin="2.PickingUp")
    assert blamed(state, slip, rule) == ({"grasp(block)"}, {"2.PickingUp/up"})


def test_where_something_was_in_the_way_the_hand_goes_another_way_at_once(state: State) -> None:
    gone = Finding("end", False, "it lies beside the shelf", things=True)
    hit = Finding("hits", False, "the hand hits the post", origin="3.Placing/Retracting", blocking=("post",))
    assert blamed(state, gone, hit) == ({"grasp(block)", "on(shelf)", "3.Placing/Retracting/away"}, {"2.PickingUp/up"})


def test_an_objection_that_is_not_known_to_be_about_things_blames_all_places_at_once(state: State) -> None:
    force = Finding("force", False, "the arm felt 61 N", origin="2.PickingUp")
    assert blamed(state, force) == ({"grasp(block)", "2.PickingUp/up"}, set())


def test_what_was_chosen_for_later_steps_of_a_task_is_not_blamed(state: State) -> None:
    """A plate that was laid down too hard was put there four times, and the hand went back otherwise each time."""
    force = Finding("force", False, "the arm felt 61 N", origin="3.Placing/PuttingDown")
    assert blamed(state, force) == ({"grasp(block)", "2.PickingUp/up", "on(shelf)"}, set())
