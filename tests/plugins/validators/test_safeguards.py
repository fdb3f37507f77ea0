"""What watches over the tasks of a text: each way to lose it, and the edit beside it that keeps it."""

from __future__ import annotations

import pytest
from helpers.short_runs import good
from msgspec.structs import replace

from cramlite.model import Code
from cramlite.plugin import Finding
from cramlite_plugins.validators.safeguards import Safeguards, validators

TEXT = """def place():
  global catching = False
  global force_limit = 0.0
  def abort(reason):
    textmsg("abort: ", reason)
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


CLOSE = '  move_gripper(255, 157, 33, "object", 3.0, "1.Grasping/close")  # 48 N\n'
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
        ("    halt\n", "", "gone"),
        ("force_limit = 60.0", "force_limit = 60.1", "gone"),
        ("force_limit = 60.0", "force_limit = 0.0", "gone"),
        ("  check_start([2.8, -1.7, 1.5, -1.3, -1.5, 1.2], 0.01)\n", "", "check_start"),
        ("catching = False", "catching = True", "catching"),
        (MOVE, "  kill watchdog_thread\n" + MOVE, "before the tasks are done"),
        (MOVE, MOVE + "  force_limit = 500.0\n", "sets what a safeguard"),
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
        (CLOSE, ""),  # whether a step is done is asked by others
        (CLOSE, CLOSE + CLOSE.replace("1.", "9.")),
    ],
)
def test_an_edit_beside_it_passes(old: str, new: str) -> None:
    assert objections(old, new) == []


def test_only_an_edited_text_is_asked() -> None:
    assert list(Safeguards().check(good())) == []
    assert findings(TEXT) == []
    assert findings('{"format": 1}') == []  # a typed program has none of them
