"""The tables of signs that bind name only signs that clauses have."""

from __future__ import annotations

from cramlite import Engine, find_scenario, read_scenario
from cramlite.language import english
from cramlite.language.frames import Frames
from cramlite.language.labels import Labels
from cramlite.language.signs import Signs
from cramlite.planning.operators import Grounder

CLAUSES = (
    "if the tin is open", "put it on the tray by 30 mm please", "you want the tin in the drawer", "my wife asked for the tin",
    "he would be glad", "nobody may open it", "it was meant for the tray", "the guests have left", "the tin must be closed",
    "the napkin folded", "the plate lies in the drawer", "the mug holds it",
)  # fmt: skip
JOINED = {"main", "reason", "dependent", "oriented"}
"""Signs that say how a clause is joined to the sentence, which a clause alone has not."""


def test_every_sign_of_a_table_is_one_that_clauses_have() -> None:
    engine = Engine()
    scene = engine.setting(read_scenario(find_scenario("kitchen/kitchen_of_thirteen")), twins=0).symbolic(engine.knowledge.taxonomy)
    labels = Labels(scene)
    frames = Frames(Grounder(scene, engine.knowledge.predicates).fluents.phrases)
    signs = Signs(frames, labels.calls, lambda w: labels.calls(w) or not labels.unknown((w,)))
    found = {sign for clause in CLAUSES for sign in signs.of(tuple(clause.split()))}
    asked = {sign for together in (*english.BINDING, *english.ALONE) for sign in together}
    missing = sorted(asked - found - JOINED)
    assert missing == []
