"""RobCoG's event data and its poses, which are Unreal's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.robcog_samples import TIMELINE, Lines, event_data
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Pose
from cramlite_plugins.episodes.formats.neem import read_neem
from cramlite_plugins.episodes.formats.robcog import to_unreal, unreal_pose


@given(st.lists(st.floats(-1, 1), min_size=7, max_size=7).filter(lambda v: np.linalg.norm(v[3:]) > 0.1))
def test_unreal_poses_and_back(v: list[float]) -> None:
    pose = Pose((v[0], v[1], v[2]), (v[3], v[4], v[5], v[6]))
    assert unreal_pose(to_unreal(pose)).distance(pose) == pytest.approx((0, 0), abs=1e-6)


KNOWROB = {False: "knowrob:", True: "http://knowrob.org/kb/knowrob_u.owl#"}


@pytest.mark.parametrize("old", [False, True])
def test_both_generations_of_robcog(tmp_path: Path, old: bool) -> None:
    (tmp_path / "X_ED.owl").write_text(event_data(*TIMELINE, old=old))
    found = read_neem(tmp_path)
    assert found is not None
    assert [(e.type, e.kind, e.start, e.end) for e in found.events] == [
        ("soma:SupportState", "state", 0.5, 4.0),
        ("soma:Reaching", "action", 1.0, 2.0),
        ("soma:ContactState", "state", 1.25, 2.5),
        ("cram:GraspState", "state", 3.5, 5.0),
        (f"{KNOWROB[old]}ContainerManipulation", "action", 6.0, 7.0),
    ]
    assert found.events[0].roles == {"supporter": "table", "supportee": "cup"}
    assert set(found.events[2].roles.values()) == {"hand", "cup"}
    assert found.effector == "hand"
    assert {r.what for r in found.repairs} == {f"added entity '{n}'" for n in ("cup", "hand", "table")}


def test_impossible_events_are_left_out_and_reported(tmp_path: Path) -> None:
    lines: Lines = (("a", "TouchingSituation", 2, 1, {"inContact": "x", "inContact_": "y"}),
             ("b", "TouchingSituation", "soon", 1, {"inContact": "x"}),
             ("c", "TouchingSituation", "nan", 1, {"inContact": "x"}),
             ("d", "TouchingSituation", 1, 2, {"inContact": "x", "inContact_": "y"}),
             ("d", "TouchingSituation", 3, 4, {}))  # fmt: skip
    (tmp_path / "X_ED.owl").write_text(event_data(*lines))
    found = read_neem(tmp_path / "X_ED.owl")
    assert found is not None
    assert [(e.id, e.start, e.end) for e in found.events] == [("d_1", 1.0, 2.0), ("d_2", 3.0, 4.0)]
    assert {r.what for r in found.repairs} >= {f"left out event '{k}'" for k in "abc"} | {"split event 'd' in 2"}


MAP = """<?xml version="1.0"?>
<!DOCTYPE rdf:RDF [<!ENTITY k "http://knowrob.org/kb/knowrob.owl#"> <!ENTITY log "http://knowrob.org/kb/ameva_log.owl#">]>
<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#" xmlns:rdfs="http://www.w3.org/2000/01/rdf-schema#"
         xmlns:owl="http://www.w3.org/2002/07/owl#" xmlns:k="http://knowrob.org/kb/knowrob.owl#">
{}</rdf:RDF>
"""
CLASS = """<owl:Class rdf:about="&k;{name}">{sizes}<k:mass>4.7</k:mass></owl:Class>
"""
SIZE = """<rdfs:subClassOf><owl:Restriction>
  <owl:onProperty rdf:resource="&k;{}OfObject"/><owl:hasValue>{}</owl:hasValue>
</owl:Restriction></rdfs:subClassOf>"""
THING = """<owl:NamedIndividual rdf:about="&log;{id}"><rdf:type rdf:resource="&k;{name}"/>
  <k:describedInMap rdf:resource="&log;map"/>{child}<k:pose rdf:resource="&log;{id}_pose"/>
</owl:NamedIndividual>
<owl:NamedIndividual rdf:about="&log;{id}_pose"><rdf:type rdf:resource="&k;Pose"/>
  <k:quaternion>0 0 0 1</k:quaternion><k:translation>{at}</k:translation>
</owl:NamedIndividual>
"""


@pytest.mark.parametrize("sizes", [(("depth", 59.0), ("width", 4.0), ("height", 70.0)), (("depth", 59.0), ("width", 4.0))])
def test_a_map_has_sizes_masses_and_parts(tmp_path: Path, sizes: tuple[tuple[str, float], ...]) -> None:
    """As the kitchen that test_neem reads where it is: lengths in cm along Unreal's axes, parts where their wholes are."""
    door = CLASS.format(name="Door", sizes="".join(SIZE.format(*s) for s in sizes))
    whole = THING.format(id="d1", name="Door", at="-173 -237 52", child='<k:child rdf:resource="&log;h1"/>')
    handle = THING.format(id="h1", name="Handle", at="-173 -230 62", child="")
    (tmp_path / "K_SM.owl").write_text(MAP.format(door + whole + handle))
    found = read_neem(tmp_path / "K_SM.owl")
    assert found is not None and not found.repairs
    one, part = found.entity("d1"), found.entity("h1")
    assert one.types == ("knowrob:Door",) and one.properties == {"mass": 4.7}
    assert one.size == (pytest.approx((0.59, 0.04, 0.70)) if len(sizes) == 3 else None)
    assert one.pose is not None and one.pose.position == pytest.approx((-2.37, -1.73, 0.52))
    assert part.part_of == "d1"
    assert part.pose is not None and part.pose.position == pytest.approx((0.07, 0.0, 0.10))
