"""What watches over the tasks of a text: each way to lose it, and the edit beside it that keeps it."""

from __future__ import annotations

import pytest
from helpers.short_runs import good
from msgspec.structs import replace

from cramlite.model import (
    AnyStep,
    Code,
    Monitor,
    MoveUntilContact,
    Program,
    SetGripper,
    Wait,
    ZeroSensor,
    write_program,
)
from cramlite.plugin import Finding
from cramlite_plugins.validators.safeguards import Safeguards, validators

TEXT = """def place():
  global catching = False
  global force_limit = 0.0
  def abort(reason):
    textmsg("abort: ", reason)
    halt
  end
  def fail(reason):
    halt
  end
  global lift_pose = p[0.5, 0.2, 0.151, 0.0, 3.141593, 0.0]
  global force_limit = 60.0  # protective limit on the TCP force [N]
  check_start([2.8, -1.7, 1.5, -1.3, -1.5, 1.2], 0.01)
  global watchdog_thread = run watchdog()

  # ---- 1.Grasping: Patient block (step 1) ----
  # 1.Grasping/close: hold block
  move_gripper(255, 157, 33, "object", 3.0, "1.Grasping/close")  # 48 N
  # 2.PickingUp/lift: straight up
  movel(lift_pose, a=0.5, v=0.1)
  # 3.Grasping/close: hold block again
  move_gripper(255, 157, 33, "object", 3.0, "3.Grasping/close")  # 48 N

  kill watchdog_thread
end
"""

MOVE = "  movel(lift_pose, a=0.5, v=0.1)\n"


CALL = '  move_gripper(255, 157, 33, "object", 3.0, "1.Grasping/close")  # 48 N\n'
FREE = "  freedrive_mode()\n"
KILL = "  kill watchdog_thread\n"


def findings(text: str) -> list[Finding]:
    """What is said of a text that was edited from the proven one."""
    edited, proven = (Code("urscript", t, {}, ".script") for t in (text, TEXT))
    return list(Safeguards().check(replace(good(), code=edited, proven=proven)))


def objections(old: str, new: str) -> list[str]:
    """What is said of the text in which one part stands for another: objections, or that nothing is wrong."""
    assert old in TEXT
    found = findings(TEXT.replace(old, new, 1))
    assert len({f.passed for f in found}) == 1
    return [f.reason for f in found if not f.passed]


def test_it_is_asked() -> None:
    assert [v.name for v in validators()] == ["safeguards"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("    halt\n", "", "'halt' of the proven text is gone"),
        ("force_limit = 60.0", "force_limit = 60.1", "gone"),
        ("force_limit = 60.0", "force_limit = 0.0", "gone"),
        ("  check_start([2.8, -1.7, 1.5, -1.3, -1.5, 1.2], 0.01)\n", "", "check_start"),
        ("catching = False", "catching = True", "catching"),
        (MOVE, "  kill watchdog_thread\n" + MOVE, "before the tasks are done"),
        (MOVE, MOVE + "  force_limit = 500.0\n", "overwrites a setting of a safeguard"),
        ('"object"', '"any"', "1.Grasping/close no longer asks for 'object'"),
        (MOVE, MOVE + "  freedrive_mode()\n", "freedrive_mode"),
        (MOVE, MOVE + "  force_mode(lift_pose, [0, 0, 1, 0, 0, 0])\n", "force_mode"),
        (MOVE, FREE + "  end_freedrive_mode()\n" + MOVE + FREE, "freedrive_mode"),
    ],
)
def test_a_safeguard_that_is_lost(old: str, new: str, said: str) -> None:
    assert any(said in reason for reason in objections(old, new))


def test_of_equal_lines_those_are_new_that_the_proven_text_has_not() -> None:
    assert len(objections(MOVE, KILL + MOVE)) == 1


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("force_limit = 60.0", "force_limit = 45.0"),
        ("force_limit = 60.0", "force_limit = 60.00"),
        ("force_limit = 60.0", "force_limit = 0.5"),
        ("lift_pose", "taught_point"),
        ("0.151", "0.171"),
        ("  # protective limit on the TCP force [N]", ""),
        ("  check_start", '  textmsg("cell 4")\n\n  check_start'),
        ("255, 157, 33", "255, 157, 36"),
        (MOVE, MOVE + "  sleep(0.5)\n"),
        (MOVE, MOVE + "  freedrive_mode()\n  sleep(0.5)\n  end_freedrive_mode()\n"),
        (MOVE, "  i = 0\n" + MOVE),
        (CALL, ""),  # whether a step is done is asked by others
        (CALL, CALL + CALL.replace("1.", "9.")),
        (MOVE, MOVE + '  move_gripper(0, 157, 33, "none", 3.0, "3.Opening/open")\n'),
    ],
)
def test_an_edit_beside_it_passes(old: str, new: str) -> None:
    assert objections(old, new) == []


def test_a_limit_that_is_raised_is_named() -> None:
    said = objections("force_limit = 60.0", "force_limit = 90.0")
    assert said[0].startswith("'global force_limit = 60.0' of the proven text is gone")


def test_only_an_edited_text_is_asked() -> None:
    assert list(Safeguards().check(good())) == []
    assert findings(TEXT) == []


def test_the_statement_that_is_lost_is_named_in_a_long_text() -> None:
    """One that is there stands in the text hundreds of times, behind a force limit that is raised and before what is lost."""
    start = "  check_start([2.8, -1.7, 1.5, -1.3, -1.5, 1.2], 0.01)\n"
    proven = TEXT.replace(start, "  sync()\n" + start).replace(MOVE, 150 * (MOVE + "  sync()\n"))
    edited = proven.replace(start, "").replace("force_limit = 60.0", "force_limit = 90.0")
    code = [Code("urscript", t, {}, ".script") for t in (edited, proven)]
    said = [f.reason for f in Safeguards().check(replace(good(), code=code[0], proven=code[1])) if not f.passed]
    assert any(reason.startswith("'check_start(") and "of the proven text is gone" in reason for reason in said)


TARE = "3.Placing/PuttingDown/tare"
LOWER = "3.Placing/PuttingDown/lower"
CLOSE = "1.Grasping/close"


def tared(*lines: str) -> list[str]:
    """What is said of a text whose tare has these lines, of which the proven one has a pause and the call."""

    def code(*own: str) -> Code:
        text = [*TEXT.splitlines()[:-3], f"  # {TARE}: no contact", *own, f"  # {LOWER}: down", "  sleep(0.1)", "end"]
        first = text.index(f"  # {TARE}: no contact") + 1
        return Code("urscript", "\n".join(text), {first: TARE, first + len(own) + 1: LOWER}, ".script")

    steps = (ZeroSensor(origin=TARE), Wait(0.1, origin=LOWER))
    base = good()
    asked = replace(base, program=replace(base.program, steps=steps), code=code(*lines))
    found = Safeguards().check(replace(asked, proven=code("  sleep(0.3)  # settle", "  zero_ftsensor()")))
    return [f.reason for f in found if not f.passed]


@pytest.mark.parametrize("lines", [("  sleep(0.3)",), ("  # zero_ftsensor()",), ('  textmsg("zero_ftsensor()")', "  sleep(0.3)")])
def test_a_tare_that_is_a_pause_by_now(lines: tuple[str, ...]) -> None:
    (reason,) = tared(*lines)
    assert reason.startswith(f"{TARE} no longer calls 'zero_ftsensor'")


@pytest.mark.parametrize("lines", [("  zero_ftsensor()",), ("  sleep(0.5)", "  zero_ftsensor()  # again", "  sync()")])
def test_a_tare_beside_it_passes(lines: tuple[str, ...]) -> None:
    assert tared(*lines) == []


DOWN = f'  move_until_contact([0.0, 0.0, -1.0], 0.03, 0.01, 3.0, 9.0, "any", "{LOWER}")'


@pytest.mark.parametrize(
    ("lines", "lost"),
    [
        (("  movel(lift_pose, a=0.5, v=0.1)", DOWN), False),
        ((DOWN.replace("3.0, 9.0", "5.0, 9.0"), "  sleep(0.3)"), False),
        (("  movel(lift_pose, a=0.5, v=0.1)",), True),
        (("  movel(lift_pose, a=0.5, v=0.1)", "  # " + DOWN.strip()), True),
        ((), False),  # that all of a step is gone is said by others
    ],
)
def test_a_step_that_felt_its_way_still_does(lines: tuple[str, ...], lost: bool) -> None:
    def code(*own: str) -> Code:
        text = [*TEXT.splitlines()[:-3], f"  # {LOWER}: down", *own, "end"]
        first = text.index(f"  # {LOWER}: down") + 1
        return Code("urscript", "\n".join(text), {first: LOWER, first + len(own) + 1: CLOSE}, ".script")

    asked = replace(good(), code=code(*lines), proven=code("  movel(lift_pose, a=0.5, v=0.1)", DOWN))
    said = [f.reason for f in Safeguards().check(asked) if not f.passed]
    assert said == [f"{LOWER} has no guarded motion any more: the motion after it would hit an obstacle there unguarded"] * lost


def test_a_typed_step_that_felt_its_way_still_does() -> None:
    two = [Wait(0.2, origin=LOWER), *steps(limit=None)]
    (said,) = typed([s for s in two if not isinstance(s, MoveUntilContact)], proven=two)
    assert said == f"{LOWER} has no guarded motion any more: the motion after it would hit an obstacle there unguarded"
    bare = [s for s in steps() if not isinstance(s, MoveUntilContact | Monitor)]
    gone = [s for s in steps() if not isinstance(s, Monitor)]
    assert typed(bare, proven=gone) == []  # that all of a step is gone is said by others
    assert typed([*two, two[-1]], proven=two) == []


def steps(
    limit: float | None = 20.0, slip: float | None = None, closes: str = "object", meets: str = "contact"
) -> list[AnyStep]:
    """Steps of a typed program."""
    return [
        SetGripper(0.0, 0.1, 48.0, closes, origin=CLOSE),  # type: ignore[arg-type]
        ZeroSensor(origin=TARE),
        Monitor((Wait(0.1, origin=LOWER),), force=limit, slip=slip),
        MoveUntilContact((0.0, 0.0, -1.0), 0.01, 3.0, 0.03, 9.0, meets, origin=LOWER),  # type: ignore[arg-type]
    ]


def typed(made: list[AnyStep], proven: list[AnyStep] | None = None, limit: float = 60.0, **more: object) -> list[str]:
    """What is said of an edited typed program."""
    base = good()
    program: Program = replace(base.program, steps=tuple(proven or steps()), force_limit=limit)
    text = write_program(replace(program, steps=tuple(made), **more))
    asked = replace(base, program=program, code=Code("", text, {}, ""), proven=Code("urscript", TEXT, {}, ".script"))
    found = list(Safeguards().check(asked))
    assert found
    return [f.reason for f in found if not f.passed]


@pytest.mark.parametrize(
    ("made", "more", "said"),
    [
        (steps(), {"force_limit": 60.1}, "force_limit is 60.1 N"),
        (steps(), {"force_limit": 0.0}, "force_limit is 0 N"),
        (steps(), {"start": (0.0,) * 6}, "start is not that"),
        (steps(closes="any"), {}, "no longer asks for 'object'"),
        (steps(meets="any"), {}, "no longer asks for 'contact'"),
        ([s for s in steps() if not isinstance(s, ZeroSensor)], {}, "no longer calls 'ZeroSensor'"),
        ([Wait(0.3, origin=TARE) if isinstance(s, ZeroSensor) else s for s in steps()], {}, "no longer calls 'ZeroSensor'"),
        (steps(limit=20.1), {}, "(force 20)"),
        (steps(limit=None, slip=0.01), {}, "(force 20)"),
        ([Wait(0.1, origin=LOWER) if isinstance(s, Monitor) else s for s in steps()], {}, "(force 20)"),
    ],
)  # fmt: skip
def test_a_typed_program_that_lost_a_safeguard(made: list[AnyStep], more: dict[str, object], said: str) -> None:
    (reason,) = typed(made, **more)
    assert said in reason


@pytest.mark.parametrize(
    ("made", "more"),
    [
        (steps(), {"name": "other"}),
        (steps(), {"force_limit": 45.0}),
        (steps(limit=15.0), {}),
        (steps(slip=0.01), {}),
        ([Wait(1.0, origin=TARE), *steps(), Wait(1.0, origin=TARE)], {}),
        ([Monitor((Wait(0.2, origin=CLOSE),), time=1.0), *steps()], {}),
        ([Wait(0.1, origin=TARE) if isinstance(s, Wait) else s for s in steps()], {}),
    ],
)
def test_a_typed_edit_beside_it_passes(made: list[AnyStep], more: dict[str, object]) -> None:
    assert typed(made, **more) == []


def test_limits_of_less_than_a_newton_are_limits() -> None:
    assert typed(steps(), limit=0.8, force_limit=0.5) == typed(steps(), force_limit=0.5) == []
    assert "force_limit is 0.9 N" in typed(steps(), limit=0.8, force_limit=0.9)[0]


def test_where_no_force_was_limited_none_need_be() -> None:
    assert typed(steps(), limit=0.0, name="other") == typed(steps(), limit=0.0, force_limit=80.0) == []


def test_each_monitor_is_asked_for_in_its_order() -> None:
    """Two watch the same steps, one after the other: one that stands for both is one too few."""
    twice = [*steps(), Monitor((Wait(0.1, origin=LOWER),), force=10.0)]
    assert typed(twice, proven=twice) == []
    assert typed([*twice, *steps()], proven=twice) == []
    (said,) = typed(twice[:-1], proven=twice)
    assert "(force 10)" in said
    once = [s for k, s in enumerate(twice) if k != 2]  # the closer one stands for the first, and nothing for the second
    (said,) = typed(once, proven=twice)
    assert "(force 10)" in said
