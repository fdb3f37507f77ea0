"""A thing that is asked for by name: taken while it is there, refused once it was taken away."""

from __future__ import annotations

from helpers.placing import believed, context_of

from cramlite.model import Object
from cramlite.plugin import Grounding, Refused
from cramlite_plugins.locations.objects import resolve_object


def test_a_named_thing_is_taken_while_it_is_there() -> None:
    belief = believed()
    (found,) = resolve_object(Object("supported", entity="it"), belief, context_of(belief))
    assert isinstance(found, Grounding) and found.value == "it"


def test_a_named_thing_that_is_gone_is_refused_with_those_there_are() -> None:
    belief = believed()
    for entity in ("gone", "gone/surface"):
        (found,) = resolve_object(Object("supported", entity=entity), belief, context_of(belief))
        assert isinstance(found, Refused) and found.value == entity
        assert found.reason == "no thing of this name is in the believed world, which has shelf, it"
