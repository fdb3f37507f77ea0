"""Order in which changed scenes are played, and what their table counts."""

from __future__ import annotations

import json
from pathlib import Path

import changed_scenes
import pytest

from cramlite.experiment.benchmark.results import Attempt, EpisodeResult
from cramlite.experiment.benchmark.spec import Episode
from cramlite.model import Deviation, Notice


@pytest.fixture
def groups(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> changed_scenes.Families:
    """Families of manifests of our own: 12 cases of each of two kinds on three tasks, and 4 cancelled ones."""

    def case(name: str, task: int, kind: str, operation: str, state: int) -> dict[str, object]:
        scenario = {"change_type": kind, "trigger": {}, "change": {"operation": operation}}
        return {"case_id": name, "init_state_index": state, "task_suite_name": "libero_goal", "task_index": task, "scenario": scenario}

    core = [case(f"m{k}", k % 3, "target_relocation", "move_object", 1) for k in range(12)]
    core += [case(f"o{k}", k % 3, "obstacle_insertion", "insert_obstacle", 1) for k in range(12)]
    intent = [case(f"i{k}", k, "task_cancel", "cancel_instruction", 0) for k in range(4)]
    for name, cases in (("core_dev.json", core), ("intent_dev.json", intent)):
        (tmp_path / name).write_text(json.dumps({"cases": cases}))
    monkeypatch.setenv("CRAMLITE_LIBERO_MAX", str(tmp_path))
    return changed_scenes.families(end=False)


def result(
    episode: Episode, rest: bool, changed: int | None = None, outcome: str = "finished", notice: float | None = None
) -> EpisodeResult:  # fmt: skip
    notices = () if notice is None else (Notice(Deviation.MOVED, notice, "it moved"),)
    attempt = Attempt(outcome=outcome, first=9 if rest else None, rest=rest, steps=9, changed=changed, notices=notices, avoided=True)
    return EpisodeResult(suite=episode.suite, task=episode.task, state=episode.state, name="put", budget=20, proven=True, attempt=attempt)


def test_the_parts_share_no_case_and_no_state(groups: changed_scenes.Families) -> None:
    end = changed_scenes.families(end=True)
    parts = [{c for cases in part.values() for c, _ in cases} for part in (groups, end)]
    assert len(parts[0] | parts[1]) == 28 and not parts[0] & parts[1] and len(parts[1]) > 4
    assert not set(changed_scenes.safe(end=False)) & set(changed_scenes.safe(end=True))


def test_rounds_take_turns_and_controls_follow_their_first_case(groups: changed_scenes.Families) -> None:
    scenes = changed_scenes.safe(end=False)
    found = list(changed_scenes.order(groups, scenes, 3))
    assert found == list(changed_scenes.order(groups, scenes, 3)) != list(changed_scenes.order(groups, scenes, 4))
    kinds = {case: family for family, cases in groups.items() for case, _ in cases}
    physical = {"obstacle_insertion", "target_relocation"}
    for e in found:
        said = changed_scenes.kind_of(e)
        assert said == ("safe" if e in scenes else "asked" if "intent" in e.suite else "physical")
        assert e not in kinds or (said == "physical") == (kinds[e] in physical)
    changed = [kinds.get(e, "safe") for e in found if e.state == changed_scenes.CHANGED and "max" in e.suite]
    assert {*changed[:3]} == {"obstacle_insertion", "target_relocation", "task_cancel"}
    controls = [e for e in found if e.state == changed_scenes.CONTROL and "max" in e.suite]
    assert len({*found}) == len(found) and len(controls) == 3 + len(groups["task_cancel"]), "tasks share controls"
    assert found[1] == Episode(found[0].suite, found[0].task, changed_scenes.CONTROL)


def test_the_table_counts_what_a_change_cost(groups: changed_scenes.Families, capsys: pytest.CaptureFixture[str]) -> None:
    (lost, same), *others = groups["target_relocation"]
    kept = next(case for case, other in others if other == same)
    died = next(case for case, other in others if other != same)
    scene = changed_scenes.safe(end=False)[0]
    control = Episode(lost.suite, lost.task, changed_scenes.CONTROL)
    results = {
        lost: result(lost, False, 4, notice=0.3), kept: result(kept, True, 4, notice=0.3),
        died: result(died, False, outcome="benchmark died"), control: result(control, True), scene: result(scene, True),
    }  # fmt: skip
    numbers = {(n.what, n.part): (n.hits, n.of, n.value) for n in changed_scenes.numbers(groups, [scene], results)}
    assert numbers["target_relocation", "changed, true at rest"][:2] == (1, 2)
    assert numbers["target_relocation", "control"][:2] == (2, 2)
    assert numbers["target_relocation", "lost where the control is true"][:2] == (1, 2)
    assert numbers["controls in which something was noticed", ""][:2] == (0, 1)
    assert numbers["from change to notice, simulated", "median"][2] == pytest.approx(0.1)
    assert numbers["SafeLIBERO", "both"][:2] == (1, 1)
    assert "| SafeLIBERO | both | 1 of 1 |" in capsys.readouterr().out


def test_by_camera_what_a_picture_shows_changes_too(groups: changed_scenes.Families, tmp_path: Path) -> None:
    core = json.loads((tmp_path / "core_dev.json").read_text())["cases"]
    light = {"change_type": "illumination_switch", "trigger": {}, "change": {"operation": "set_lighting"}}
    many = {"change_type": "distractor_burst", "trigger": {}, "change": {"operation": "insert_distractors"}}
    core += [core[0] | {"case_id": "l0", "scenario": light}, core[0] | {"case_id": "d0", "scenario": many}]
    core += [core[0] | {"case_id": "l1", "scenario": light, "init_state_index": 0}]
    (tmp_path / "core_dev.json").write_text(json.dumps({"cases": core}))
    development, end = (changed_scenes.families(end=part, camera=True) for part in (False, True))
    physical = {"target_relocation": 12, "obstacle_insertion": 12}
    assert {f: len(c) for f, c in end.items()} == physical | {"illumination_switch": 1, "task_cancel": 2}
    assert {f: len(c) for f, c in development.items()} == {"illumination_switch": 1, "task_cancel": 2}, "the states are apart"
