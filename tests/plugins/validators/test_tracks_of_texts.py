"""Proven programs whose text does more than its tasks say, judged again; and some that resemble them and pass."""

from __future__ import annotations

import pytest
from helpers.edited import against, proven, replaced
from msgspec.structs import replace

from cramlite.model import Pose, World
from cramlite.plugin import Candidate
from cramlite_plugins.objects.vessels import can

LIFT, TOOL = "movel(picking_up_2_lift_pose, a=0.5, v=0.1)", "0.0, 3.141593, 0.0], a=0.5, v=0.15)"
OPEN, CLOSE = 'move_gripper(15, 157, 0, "none", 3.0, "y")', 'move_gripper(255, 157, 33, "object", 3.0, "x")'
PARK = "  kill watchdog_thread"


def led(*places: tuple[float, float, float] | str) -> str:
    """Lines of code: straight motions of the tool, and others as they are."""
    return "\n".join(f"  {p}" if isinstance(p, str) else f"  movel(p[{p[0]}, {p[1]}, {p[2]}, {TOOL}" for p in places) + "\n"


def with_tin(candidate: Candidate) -> World:
    tin = can("tin", Pose((0.35, 0.0, 0.0625)), radius=0.03, height=0.1)
    return replace(candidate.world, things=(*candidate.world.things, tin))


TAKE = ((0.35, 0.0, 0.3), (0.35, 0.0, 0.06), CLOSE)
BAD: dict[str, tuple[str, str]] = {
    "a tin carried aside": (PARK, led(*TAKE, (0.35, 0.0, 0.16), (0.35, 0.15, 0.06), OPEN, (0.35, 0.15, 0.3)) + PARK),
    "a tin taken and put back": (PARK, led(*TAKE, (0.35, 0.0, 0.16), (0.35, 0.0, 0.06), OPEN, (0.35, 0.0, 0.3)) + PARK),
    "a tin dropped": (PARK, led(*TAKE, (0.35, 0.0, 0.4), OPEN) + PARK),
    "a block let go and taken again": (LIFT, f"{LIFT}\n" + led((0.5, 0.2, 0.054), OPEN, CLOSE) + f"  {LIFT}"),
    "a block dragged": ("  set_target_payload(1.125", led((0.5, 0.05, 0.05)) + "  set_target_payload(1.125"),
}


@pytest.mark.heavy
@pytest.mark.parametrize("what", BAD)
def test_a_text_that_does_more_than_its_tasks_is_refused(what: str) -> None:
    candidate = proven("placing")
    found = against(candidate, replaced(candidate, BAD[what]), with_tin(candidate))
    thing = "tin" if "tin" in what else "block"
    assert f"'{thing}' was " in found["tracks"]


def test_a_text_that_waits_or_places_aside_passes() -> None:
    candidate = proven("placing")
    aside = [(f"placing_3_{name}_pose = p[0.45", f"placing_3_{name}_pose = p[0.48") for name in ("putting_down_lower", "retracting_back")]
    text = replaced(candidate, (LIFT, f"{LIFT}\n  sleep(1.0)"), *aside)
    assert against(candidate, text, with_tin(candidate)) == {}


@pytest.mark.heavy
def test_a_lid_beside_its_pot_is_refused() -> None:
    candidate = proven("lid_on_pot", folder="kitchen")
    assert candidate.code is not None
    (line,) = (t for t in candidate.code.text.splitlines() if "lower_pose = p[" in t)
    x = line.split("p[")[1].split(",")[0]
    for aside, passes in ((0.005, True), (0.03, False)):
        found = against(candidate, replaced(candidate, (line, line.replace(f"p[{x}", f"p[{float(x) + aside:.6f}"))))
        assert ("end_state" not in found) is passes, found
        assert passes or "of the opening of 'pot' uncovered" in found["end_state"]
