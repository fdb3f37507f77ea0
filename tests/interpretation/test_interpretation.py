"""Interpretation: which tasks actions are, which they are not and why, holes, and merging."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
import pytest
from helpers.interpretation_reading import BOX, RULES, TABLE, at, read, tasks
from helpers.interpretation_samples import action, episode, hanger_episode, state, track

from cramlite.model import Entity, Pose
from cramlite.plugin import UserError

CONTAINER = Entity("jar", ("soma:Jar",), pose=Pose((0.5, 0, 0)), size=(0.1, 0.1, 0.1))


def test_a_product_is_taken_off_a_hanger_and_dropped_into_a_basket() -> None:
    found = read(hanger_episode())
    best = next(found.sequences())
    assert [m.task for m in best.matches] == [
        "soma:Grasping",  # a hand that takes hold has come there
        "artm:ExtractHoleFromPeg",
        "artm:Ungrasping",
        "soma:Retracting",
    ]
    assert best.matches[1].roles == {"Locatum": "product", "Relatum": "hanger/peg"}
    assert best.matches[2].roles == {"Locatum": "product", "Relatum": "basket"}
    assert {"soma:Reaching", "soma:AssumingArmPose"} <= {m.task for a in found.actions for m in a.matches}
    assert "soma:AssumingArmPose" in tasks(at(found, 5.0))


def test_without_friction_there_is_no_grasp_and_nothing_that_needs_one() -> None:
    needs = {
        "soma:Grasping",
        "soma:Holding",
        "soma:Releasing",
        "artm:Ungrasping",
        "soma:PickingUp",
        "soma:PuttingDown",
        "soma:Placing",
        "artm:ExtractHoleFromPeg",
        "artm:InsertHoleOntoPeg",
        "artm:SlidingObject",
        "soma:Transporting",
    }
    for one in read(hanger_episode(friction=False)).actions:
        assert not tasks(one) & needs


def test_every_task_is_matched_or_rejected_with_the_reason() -> None:
    found = read(hanger_episode())
    for one in found.actions:
        assert tasks(one) | {r.task for r in one.rejections} == {r.task for r in RULES}
        assert not tasks(one) & {r.task for r in one.rejections}
        for refused in one.rejections:
            assert refused.condition in refused.sentence
            assert refused.where.rsplit(":", 1)[1].isdigit()


def test_why_and_why_not_name_bindings_and_facts() -> None:
    found = read(hanger_episode())
    k = found.actions.index(at(found, 3.0))
    text = found.why("PickUp", k)
    assert "constrained_dof(hanger, product) = 4" in text
    assert "picking_up.yaml:" in text
    assert "pulled off hanger/peg" in found.why("artm:ExtractHoleFromPeg", k)
    with pytest.raises(UserError, match="No rule speaks"):
        found.why("Juggling", k)
    with pytest.raises(UserError, match="There is no action 99"):
        found.why("Grasping", 99)


def test_json_form() -> None:
    found = read(hanger_episode())
    data = json.loads(json.dumps(found.to_json()))
    assert data["sequences"] == found.count() == math.prod(len(a["tasks"]) or 1 for a in data["actions"])
    assert {"start", "end", "tasks", "rejections"} <= set(data["actions"][0])
    assert {"task", "roles"} <= set(data["actions"][0]["tasks"][0])


def test_roles_come_from_the_action_itself_never_from_another() -> None:
    other = Entity("can", ("cram:Product",))
    sample = episode(
        [BOX, other],
        [state("grasp", "hand", "box", 1, 2), state("grasp", "hand", "can", 4, 5)],
        {"hand": track((0, 0, 0, 0), (6, 0, 0, 0))},
    )
    found = read(sample)
    assert [m.roles["Patient"] for a in found.actions for m in a.named("soma:Grasping")] == ["box", "can"]


def test_an_action_without_a_task_is_a_reported_hole() -> None:
    opening = np.array([(0, 0.0), (2, 0.1)])
    sample = episode(
        [BOX],
        [action("soma:PhysicalAction", 0, 2), state("contact", "hand", "box", 1, 2)],
        {"hand": track((0, 0, 0, 0), (2, 1, 0, 0))},
        opening,
    )
    found = read(sample)
    assert len(found.unexplained_actions) == 1
    assert found.count() == 0
    assert list(found.sequences()) == []
    assert len(found.unexplained_actions[0].rejections) == len(RULES)


def test_an_irrelevant_boundary_is_merged_with_its_evidence() -> None:
    other = [state("contact", "jar", "table", 1, 2)]
    sample = episode([CONTAINER, TABLE], other, {"hand": track((0, 2, 0, 1), (3, 3, 0, 1))})
    apart, joined = read(sample, merge=False), read(sample)
    assert len(apart.actions) == 3
    (one,) = joined.actions
    assert len(one.segments) == 3
    assert "1.00 s, 2.00 s" in one.evidence
    assert joined.count() == 1
    assert joined.to_json()["actions"][0]["merged"]["segments"] == [[0.0, 1.0], [1.0, 2.0], [2.0, 3.0]]


def test_a_boundary_that_matters_is_kept() -> None:
    sample = episode([BOX], [state("grasp", "hand", "box", 1, 2)], {"hand": track((0, 2, 0, 1), (3, 3, 0, 1))})
    assert len(read(sample).actions) == 3


def test_labelled_actions_are_never_merged() -> None:
    sample = episode(
        [],
        [action("soma:PhysicalAction", 0, 1), action("soma:PhysicalAction", 1, 2)],
        {"hand": track((0, 0, 0, 0), (2, 1, 0, 0))},
    )
    assert len(read(sample).actions) == 2


def test_every_instant_belongs_to_an_action() -> None:
    found = read(hanger_episode())
    assert found.actions[0].start == 0.0
    assert found.actions[-1].end == 8.0
    assert all(a.end == b.start for a, b in itertools.pairwise(found.actions))


def test_an_episode_without_events_has_no_actions() -> None:
    found = read(episode([], [], {}))
    assert found.actions == ()
    assert found.count() == 0
    assert list(found.sequences()) == []
