"""Queries, the planner and the running of pipelines, with small experts that are functions of a number a pixel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Object
from cramlite.ontology.taxonomy import Taxonomy
from cramlite.perception.pipeline import NoPipeline, plan_pipeline
from cramlite.perception.query import Condition, ObjectQuery, parse_query, query_from
from cramlite.perception.runner import perceive
from cramlite.plugin import Expert, Inputs, Judged, Unresolvable, UserError

CLASSES = Taxonomy({
    "cram:TeaBox": ("cram:BoxedProduct",), "cram:CoffeePack": ("cram:BoxedProduct",), "cram:BoxedProduct": ("cram:Product",),
    "cram:Hanger": ("dul:PhysicalObject",),
})  # fmt: skip
PICTURE = ("red 3", "green 5", "red 8")


def parts(inputs: Inputs) -> Mapping[str, Any]:
    return {"segments": tuple(inputs["view"])}


def colour(inputs: Inputs) -> Mapping[str, Any]:
    return {"colour": Judged(inputs["segment"].split()[0], 0.9, "it looks so")}


def size(inputs: Inputs) -> Mapping[str, Any]:
    return {"size": float(inputs["segment"].split()[1])}


def kind(inputs: Inputs) -> Mapping[str, Any]:
    tea = Judged("cram:TeaBox", 0.6)
    coffee = Judged("cram:CoffeePack", 0.4)
    return {"type": replace(tea, others=(coffee,)) if inputs["size"] < 4 else replace(coffee, others=(tea,))}


def broken(inputs: Inputs) -> Mapping[str, Any]:
    raise ZeroDivisionError("oops")


def beside(inputs: Inputs) -> Mapping[str, Any]:
    count = len(inputs["objects"])
    return {
        "relations": tuple(
            (("left_of", f"#{k + 1}", "cram:Product"),) if k < count else () for k in range(1, count + 1)
        )
    }


EXPERTS = (
    Expert("split", "", ("view",), ("segments",), parts),
    Expert("colour_word", "", ("segment",), ("colour",), colour, "object", domains={"colour": ("red", "green")}),
    Expert("ruler", "", ("segment",), ("size",), size, "object"),
    Expert("guess", "", ("size",), ("type",), kind, "object", cost_ms=5.0,
           domains={"type": ("cram:TeaBox", "cram:CoffeePack")}),
    Expert("row", "", ("objects", "segment"), ("relations",), beside, "scene", domains={"relations": ("left_of",)}),
)  # fmt: skip


def ask(text: str, *more: Expert, wanted: tuple[str, ...] = ()) -> Any:
    query = replace(parse_query(text, CLASSES, (*EXPERTS, *more)), wanted=wanted)
    return perceive(query, (*EXPERTS, *more), {"view": PICTURE}, CLASSES)


def numbers(found: Any) -> list[int]:
    return [a.number for a in found.answers]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", [1, 2, 3]),
        ("colour=red", [1, 3]),
        ("colour=red size>=5", [3]),
        ("size<=4", [1]),
        ("type=cram:TeaBox", [1]),
        ("type=BoxedProduct", [1, 2, 3]),
        ("type=Product colour=green", [2]),
        ("left_of=#2", [1]),
        ("colour=green left_of=Product", [2]),
        ("colour=red confidence>=0.95", []),
    ],
)
def test_conditions_are_a_conjunction(text: str, expected: list[int]) -> None:
    assert sorted(numbers(ask(text))) == expected


def test_only_what_the_query_needs_is_run() -> None:
    ran = [r.expert for r in ask("colour=red").runs]
    assert ran == ["split", "colour_word"]


def test_what_is_out_spares_the_dearer_experts() -> None:
    runs = {r.expert: r.count for r in ask("colour=green type=Product").runs}
    assert runs["guess"] == 1 and runs["colour_word"] == 3


def test_a_scene_expert_that_a_dear_one_uses_does_not_keep_objects_alive() -> None:
    dear = (
        Expert("fit", "", ("segment",), ("fits",), lambda _: {"fits": 1}, "object", cost_ms=90.0),
        Expert("choose", "", ("fits",), ("pose",), lambda _: {"pose": 1}, "object", uses=("relations",)),
    )
    runs = {r.expert: r.count for r in ask("colour=green", *dear, wanted=("pose",)).runs}
    assert runs["row"] == 3 and runs["fit"] == 1


def test_the_cheapest_provider_is_asked_first_and_the_next_if_it_fails() -> None:
    def coy(inputs: Inputs) -> Mapping[str, Any]:
        if inputs["segment"].startswith("green"):
            raise Unresolvable("too green for me")
        return {"colour": "red"}

    found = ask("colour=green", Expert("coy", "", ("segment",), ("colour",), coy, "object", cost_ms=0.1))
    assert numbers(found) == [2]
    assert found.answers[0].values["colour"].expert == "colour_word"
    assert found.dropped[0].values["colour"].expert == "coy"


def test_what_only_the_next_provider_needs_is_made_when_it_is_asked() -> None:
    chain = (
        Expert("hasty", "", ("segment",), ("pose",), broken, "object", cost_ms=0.01),
        Expert("thorough", "", ("mesh",), ("pose",), lambda i: {"pose": i["mesh"]}, "object"),
        Expert("mesher", "", ("segment",), ("mesh",), lambda _: {"mesh": "fine"}, "object"),
    )
    assert ask("colour=green", *chain, wanted=("pose",)).answers[0].value("pose") == "fine"


def test_a_broken_expert_is_isolated_named_and_replaced() -> None:
    found = ask("colour=red", Expert("bad", "", ("segment",), ("colour",), broken, "object", cost_ms=0.1))
    assert numbers(found) == [1, 3]
    failures = [f for r in found.runs if r.expert == "bad" for f in r.failures]
    assert len(failures) == 3 and "bad" in failures[0] and "ZeroDivisionError: oops" in failures[0]


def test_a_crash_of_the_last_provider_leaves_a_partial_answer() -> None:
    found = ask("colour=green", Expert("bad", "", ("segment",), ("pose",), broken, "object"), wanted=("pose",))
    assert numbers(found) == [2]
    assert "pose" not in found.answers[0].values
    assert any("object 2 has no pose" in r and "bad" in r for r in found.remarks)


def test_values_that_use_each_other_are_made_all_the_same() -> None:
    def say(name: str) -> Any:
        return lambda inputs: {name: Judged(name)}

    mutual = (
        Expert("a", "", ("segment",), ("x",), say("x"), "object", uses=("y",)),
        Expert("b", "", ("segment",), ("y",), say("y"), "object", uses=("x",)),
    )
    found = ask("colour=green", *mutual, wanted=("x", "y"))
    assert found.answers[0].value("x") == "x" and found.answers[0].value("y") == "y"


def test_an_expert_sees_what_it_declared_and_nothing_else() -> None:
    seen: list[set[str]] = []

    def nosy(inputs: Inputs) -> Mapping[str, Any]:
        seen.append(set(inputs.values))
        return {"pose": 1}

    ask("colour=green type=Product", Expert("nosy", "", ("size",), ("pose",), nosy, "object"), wanted=("pose",))
    assert seen == [{"size"}]


def test_outputs_that_were_declared_must_be_made() -> None:
    liar = Expert("liar", "", ("segment",), ("pose", "grasp"), lambda _: {"pose": 1}, "object")
    assert any("the expert returned no grasp" in r for r in ask("colour=green", liar, wanted=("pose",)).remarks)


def test_no_pipeline_says_which_input_nobody_makes() -> None:
    deep = (
        Expert("fit", "", ("mesh",), ("pose",), broken, "object"),
        Expert("mesher", "", ("laser",), ("mesh",), broken),
    )
    with pytest.raises(NoPipeline, match=r"'fit' needs 'mesh'.*'mesher' needs 'laser'.*no expert makes 'laser'"):
        ask("", *deep, wanted=("pose",))


def test_a_value_that_nobody_ever_says_is_refused_with_what_they_say() -> None:
    with pytest.raises(NoPipeline, match=r"'colour_word' never gives colour 'mauve'; its values are: red, green"):
        ask("colour=mauve")
    with pytest.raises(NoPipeline, match="never gives type 'cram:Hanger'"):
        ask("type=cram:Hanger")


def test_experts_that_need_each_other_make_nothing() -> None:
    circle = (Expert("a", "", ("y",), ("x",), broken), Expert("b", "", ("x",), ("y",), broken))
    with pytest.raises(NoPipeline, match="'a' needs 'y'"):
        ask("", *circle, wanted=("x",))


def test_equal_objects_are_said_to_be_ambiguous() -> None:
    assert any("2 objects fit 'colour=red' equally well: 1, 3" in r for r in ask("colour=red").remarks)
    assert not ask("colour=green").remarks


def test_nothing_found_has_reasons() -> None:
    found = ask("colour=green size>=6")
    assert not found.answers
    remark = found.remarks[0]
    assert "nothing found" in remark and "object 2: size is 5, not size>=6" in remark
    assert "object 1: colour is red" in remark


def test_what_lost_is_kept() -> None:
    found = ask("type=cram:TeaBox")
    assert [o.value for o in found.answers[0].values["type"].judged.others] == ["cram:CoffeePack"]
    assert "type is cram:CoffeePack, rather than type=cram:TeaBox" in found.dropped[0].dropped


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("colour", "no condition of a query"),
        ("colr=red", "did you mean 'color'"),
        ("type=cram:TeaBxo", "did you mean 'cram:TeaBox'"),
        ("size>=big", "'big' is no number"),
    ],
)
def test_a_wrong_query_names_what_is_right(text: str, reason: str) -> None:
    with pytest.raises(UserError, match=reason):
        parse_query(text, CLASSES, EXPERTS)


def test_a_designator_becomes_a_query() -> None:
    query = query_from(Object("object_1", ("cram:TeaBox", "dul:Object"), ("vrps:Hole",)), on="hook")
    assert str(query) == "type=cram:TeaBox features=vrps:Hole on=hook"
    assert query.outputs == ("type", "features", "relations", "pose")


def test_lengths_have_units() -> None:
    assert parse_query("size>=120mm", CLASSES, EXPERTS).conditions == (Condition("size", "GEQ", 0.12),)


@given(st.permutations(EXPERTS))
def test_the_order_of_plugins_does_not_matter(experts: list[Expert]) -> None:
    query = ObjectQuery((Condition("colour", "EQUAL", "red"), Condition("type", "CLASS", "cram:TeaBox")), wanted=())
    assert str(plan_pipeline(query, experts, {"view": PICTURE}, CLASSES)) == (
        "segments (split) -> colour (colour_word) -> size (ruler) -> type (guess)"
    )
