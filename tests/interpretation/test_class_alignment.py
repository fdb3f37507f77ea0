"""Classes of foreign logs: aligned by ontologies, which users extend."""

from __future__ import annotations

from pathlib import Path

from helpers.robcog_samples import TIMELINE, event_data
from hypothesis import given
from hypothesis import strategies as st

from cramlite import Engine
from cramlite.model import Episode, Event

TEACH = """@prefix skos: <http://www.w3.org/2004/02/skos/core#> . @prefix k: <http://knowrob.org/kb/knowrob.owl#> .
@prefix soma: <http://www.ease-crc.org/ont/SOMA.owl#> .
k:StirringSituation skos:closeMatch soma:Pushing . k:InsideSituation skos:closeMatch soma:ContainmentState ."""
OWN = (
    ("x", "StirringSituation", 1, 2, {"performedBy": "hand", "objectActedOn": "cup"}),
    ("y", "InsideSituation", 1, 3, {"container": "bowl", "content": "cup"}),
)


def test_what_robcog_cannot_say_is_an_anonymous_action(tmp_path: Path) -> None:
    (tmp_path / "X_ED.owl").write_text(event_data(*TIMELINE))
    found = Engine().read_episode(tmp_path)
    assert found.events[-1].type == "soma:PhysicalAction"
    assert not any("anonymous" in r.what for r in found.repairs)


def test_an_unknown_class_is_reported(tmp_path: Path) -> None:
    (tmp_path / "X_ED.owl").write_text(event_data(*OWN))
    found = Engine().read_episode(tmp_path)
    assert {e.type for e in found.events} == {"soma:PhysicalAction"}
    assert sum("taken as anonymous actions" in r.what for r in found.repairs) == 2


def test_users_teach_classes_in_an_ontology(tmp_path: Path) -> None:
    (tmp_path / "X_ED.owl").write_text(event_data(*OWN, old=True))
    (tmp_path / "mine.ttl").write_text(TEACH)
    found = Engine(ontologies=[tmp_path / "mine.ttl"]).read_episode(tmp_path / "X_ED.owl")
    assert {(e.type, e.kind) for e in found.events} == {
        ("soma:Pushing", "action"),
        ("soma:ContainmentState", "state"),
    }
    (state,) = found.of("state")
    assert state.roles == {"container": "bowl", "content": "cup"}


spans = st.lists(st.tuples(st.integers(0, 50), st.integers(1, 20)), max_size=20)


@given(spans, st.integers(-1, 60), st.integers(0, 10))
def test_interval_queries_find_what_looking_at_all_finds(times: list[tuple[int, int]], start: int, length: int) -> None:
    events = tuple(Event(str(k), "soma:ContactState", "state", a, a + d) for k, (a, d) in enumerate(times))
    found = Episode("x", (), events).between(start, start + length)
    assert {e.id for e in found} == {e.id for e in events if e.start <= start + length and e.end > start}
