"""What ontologies say of things reaches forces and speeds in the text, with its source in text and trace."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import pytest

from cramlite import Engine, Solution, Trace, read_scenario
from cramlite.model import Joint, Pose, Thing
from cramlite.ontology.taxonomy import load_taxonomy
from cramlite_plugins.motions.ontology_limits import classes

ROOT = Path(__file__).parents[3]
# The URScript backend, whose text is not run here: these tests are about the text.
UNRUN = """
from cramlite.plugin import hookimpl
class Unrun:
    name, executable = "unrun", False
    def emit(self, program, robot):
        from cramlite_plugins.backends.urscript.emit import emit
        return emit(program, robot)
@hookimpl
def backends():
    return [Unrun()]
"""
HEAD = """
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix cram: <http://cramlite.org/ont/cram.owl#> .
"""
SAID = "[ a owl:Restriction ; owl:onProperty {} ; owl:hasValue {} ; rdfs:comment \"{}\" ]"


class Resolved:
    """A scenario, changed, resolved up to its text."""

    def __init__(
        self, folder: Path, name: str, *changes: tuple[str, str], turtle: str = "", files: Sequence[Path] | None = None
    ) -> None:
        text = (ROOT / "scenarios" / f"{name}.yaml").read_text()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (folder / "s.yaml").write_text(text)
        (folder / "unrun.py").write_text(UNRUN)
        (folder / "own.ttl").write_text(HEAD + turtle)
        engine = Engine(files=[folder / "unrun.py"], ontologies=[folder / "own.ttl"])
        if files is not None:
            engine.knowledge.__dict__["taxonomy"] = load_taxonomy(files)
        scenario, self.trace = read_scenario(folder / "s.yaml"), Trace()
        setting = engine.setting(scenario, backend="unrun")
        self.solution: Solution | None = next(engine.resolve(scenario, setting=setting, trace=self.trace), None)
        self.text = self.solution.code if self.solution else ""
        self.reasons = "\n".join(e.reason for e in self.trace.entries)

    def called(self, function: str) -> list[float]:
        """The numbers of the last call of a function."""
        line = next(x for x in reversed(self.text.split("\n")) if re.match(rf"\s*(ok = )?{function}\(", x))
        return [float(v) for v in re.findall(r"-?\d+\.\d+", line.split("  #")[0])]

    @property
    def grip(self) -> float:
        return max(float(v) for v in re.findall(r"move_gripper\(255.*, (\d+) N", self.text))


TEA = "    model: boxed_product\n    with:"
GLASS = (TEA, "    model: boxed_product\n    type: cram:GlassBottle\n    with:")
FIFTY = ("{task: Grasping, Patient: tea}", "{task: Grasping, Patient: tea, parameters: {force_n: 50}}")


@pytest.mark.heavy
def test_a_fragile_product_lowers_forces_and_the_source_is_named(tmp_path: Path) -> None:
    usual, fragile = (Resolved(tmp_path, "take_off_hanger_tasks", FIFTY, *g) for g in ((), (GLASS,)))
    assert (usual.called("force_extract")[-2], fragile.called("force_extract")[-2]) == (25.0, 15.0)
    assert (usual.grip, fragile.grip) == (50.0, 30.0)
    for said in (fragile.text, fragile.reasons):
        assert "force_limit_n 15 instead of 25, tea (cram:GlassBottle) is a cram:FragileObject:" in said
        assert "grip 30 N instead of 50 N" in said
        assert "[motions.ttl]" in said
    assert "instead" not in usual.text


@pytest.mark.heavy
def test_without_the_axiom_the_default_is_back(tmp_path: Path) -> None:
    files = []
    for file in sorted((ROOT / "ontologies").glob("*.ttl")):
        files.append(tmp_path / file.name)
        text = file.read_text()
        files[-1].write_text(re.sub(r"\[[^]]*cram:maximum\w*Force ;.*?\](?= [,.])", "[ a owl:Class ]", text, flags=re.S))
    fragile = Resolved(tmp_path, "take_off_hanger_tasks", FIFTY, GLASS, files=files)
    assert fragile.called("force_extract")[-2] == 25.0
    assert fragile.grip == 50.0


def test_a_users_ontology_has_the_last_word(tmp_path: Path) -> None:
    nearer = SAID.format("cram:maximumForce", 9.5, "as measured")
    later = SAID.format("cram:maximumGripForce", 40, "as weighed")
    turtle = f"cram:GlassBottle rdfs:subClassOf {nearer} . cram:FragileObject rdfs:subClassOf {later} ."
    own = Resolved(tmp_path, "take_off_hanger_tasks", FIFTY, GLASS, turtle=turtle)
    assert own.called("force_extract")[-2] == 9.5
    assert own.grip == 40.0
    assert "is a cram:GlassBottle: as measured [own.ttl]" in own.text


def test_what_bears_less_than_the_gripper_presses_is_refused(tmp_path: Path) -> None:
    turtle = f"cram:GlassBottle rdfs:subClassOf {SAID.format('cram:maximumGripForce', 5, 'an egg')} ."
    egg = Resolved(tmp_path, "take_off_hanger_tasks", GLASS, turtle=turtle)
    assert egg.solution is None
    assert "the gripper presses with 20 N at least, more than 5 N: tea (cram:GlassBottle) is a" in egg.reasons


def test_heavy_things_are_moved_at_half_the_speed_and_acceleration(tmp_path: Path) -> None:
    light, heavy = (
        Resolved(tmp_path, "place_on_shelf", ("100 mm]}}", f"100 mm], mass: {mass} kg}}}}"))
        for mass in (1.9, 2.1)
    )
    rates = [re.findall(r"movej\(.*a=([\d.]+), v=([\d.]+)\)", r.text) for r in (light, heavy)]
    assert set(rates[0]) == {("1.4", "1.05")}
    assert set(rates[1]) == {("1.4", "1.05"), ("0.7", "0.525")}, "only while it is held"
    assert "speed_rad_s 0.525 instead of 1.05, block" in heavy.reasons
    assert "a quarter of the kinetic energy" in heavy.text


@pytest.mark.parametrize(("joint", "heavy"), [(None, True), (Joint("slide", Pose(), 0.0, 0.2), False)])
def test_what_rails_carry_is_no_heavy_load(joint: Joint | None, heavy: bool) -> None:
    context = SimpleNamespace(taxonomy=Engine().knowledge.taxonomy)
    drawer = Thing("drawer", "soma:Drawer", Pose(), (), mass=4.0, joint=joint)
    assert ("cram:HeavyObject" in classes(drawer, context)) == heavy  # type: ignore[arg-type]


@pytest.mark.heavy
@pytest.mark.parametrize(("diameter", "radius", "pitch"), [(8, 0.007, 0.00075), (9, 0.0065, 0.001125), (12, 0.005, 0.0015)])
def test_sizes_of_hole_and_peg_say_how_to_search(tmp_path: Path, diameter: int, radius: float, pitch: float) -> None:
    changes = (("hole_diameter: 9 mm", f"hole_diameter: {diameter} mm"), ("{search_radius_m: 0.008}", "{search_radius_m: 0}"))
    found = Resolved(tmp_path, "retry_on_hanger", *changes)
    press, turns, wide, *_ = found.called("spiral_search")[3:]
    assert (press, wide) == (3.0, radius)
    assert turns == pytest.approx(pitch, abs=1e-6)
    assert "(from motions.ttl)" in found.reasons


@pytest.mark.heavy
def test_motions_in_contact_leave_the_held_thing_less_certain(tmp_path: Path) -> None:
    found = Resolved(tmp_path, "retry_on_hanger")
    known = [float(v) for v in re.findall(r"the position of 'coffee' in the hand is uncertain by ([\d.]+) mm", found.reasons)]
    assert known[:3] == sorted(known[:3]) and known[0] > 0
    assert found.solution is not None
    let_go = found.solution.candidate.belief.poses["coffee"]
    assert let_go.sigma > 0.005, "more than what letting go alone leaves unknown"
