"""Which task a line of an edited text belongs to."""

from __future__ import annotations

import pytest

from cramlite.engine.proof.line_origins import origins_by_labels, origins_of
from cramlite.model import Code

TEXT = """def p():
  start()

  # ---- 1.Grasping ----
  # 1.Grasping/close: hold it
  close(1)
  payload(2)

  # ---- 2.Placing ----
  # 2.Placing/lower: down
  movel(a)
  open(3)

  kill watchdog
end"""
ORIGINAL = Code("urscript", TEXT, {6: "1.Grasping/close", 7: "1.Grasping/payload", 11: "2.Placing/lower", 12: "2.Placing/open"}, ".script")


def task_of(text: str, line: str) -> str:
    """The task that a line of an edited text belongs to."""
    number = [row.strip() for row in text.splitlines()].index(line) + 1
    return Code("", text, dict(origins_of(text, ORIGINAL).of), "").task_of(number)


def test_lines_that_are_as_they_were_keep_their_task() -> None:
    assert origins_of(TEXT, ORIGINAL).of == ORIGINAL.origins
    longer = TEXT.replace("  start()", "  start()\n  mine()\n  mine()")
    assert [task_of(longer, w) for w in ("close(1)", "payload(2)", "movel(a)", "mine()")] == ["1.Grasping", "1.Grasping", "2.Placing", ""]
    assert origins_of(longer, ORIGINAL).guessed == ()


def test_a_step_whose_first_line_is_gone_keeps_the_others_and_the_end_is_of_no_task() -> None:
    shorter = TEXT.replace("  movel(a)\n", "")
    assert task_of(shorter, "open(3)") == "2.Placing" and task_of(shorter, "kill watchdog") == ""
    without = TEXT.replace("  movel(a)\n  open(3)\n", "")
    assert "2.Placing" not in {task_of(without, w) for w in ("close(1)", "payload(2)", "kill watchdog")}


def test_a_changed_line_has_the_task_of_the_one_that_it_replaces() -> None:
    assert task_of(TEXT.replace("movel(a)", "movel(b)"), "movel(b)") == "2.Placing"


@pytest.mark.parametrize("new", ["mine()", "x = 3"])
def test_a_new_line_counts_to_the_one_before_and_is_said(new: str) -> None:
    text = TEXT.replace("  payload(2)\n", f"  payload(2)\n  {new}\n")
    assert task_of(text, new) == "1.Grasping" and origins_of(text, ORIGINAL).guessed == (8,)


def test_a_task_that_was_moved_is_known_by_its_name() -> None:
    lines = TEXT.splitlines()
    text = "\n".join([*lines[:3], *lines[8:13], *lines[3:8], *lines[13:]])
    assert task_of(text, "close(1)") == "1.Grasping" and task_of(text, "movel(a)") == "2.Placing"


def test_a_text_of_nobody_is_read_by_the_names_in_it() -> None:
    found = origins_by_labels("a()\n# 1.Grasping\nb()\nc()  # 3.Other\nmessage('2.Placing/lower: contact')", ["1.Grasping", "2.Placing"])
    assert found.of == {2: "1.Grasping", 5: "2.Placing"}
    assert origins_by_labels("a()\nb()", ["1.Grasping"]).of == {}


LOWER = "  # 2.Placing/lower: down\n"


@pytest.mark.parametrize("before", ["  kill watchdog\n", "  open(3)\n", "  payload(2)\n", "  start()\n"])
def test_a_comment_that_moved_changes_nothing(before: str) -> None:
    moved = TEXT.replace(LOWER, "").replace(before, LOWER + before)
    lines = ["start()", "close(1)", "payload(2)", "movel(a)", "open(3)"]
    assert [task_of(moved, w) for w in lines] == [task_of(TEXT, w) for w in lines]
    assert origins_of(moved, ORIGINAL).guessed == ()
    assert list(origins_of(moved, ORIGINAL).of.values()) == [*ORIGINAL.origins.values(), ""]


def test_code_that_moved_under_anothers_comment_is_known_by_itself() -> None:
    late = TEXT.replace("  payload(2)\n", "").replace("  open(3)\n", "  open(3)\n  # 2.Placing/open\n  payload(2)\n")
    assert origins_of(late, ORIGINAL).of[late.splitlines().index("  payload(2)") + 1] == "1.Grasping/payload"


def test_a_comment_says_whose_new_code_is_and_its_text_in_quotes_says_it_first() -> None:
    own = TEXT.replace("  movel(a)\n", "").replace("  payload(2)\n", "  payload(2)\n  # 2.Placing/lower: mine\n  mine()\n")
    assert task_of(own, "mine()") == "2.Placing" and origins_of(own, ORIGINAL).guessed == ()
    quoted = own.replace("mine()", 'mine("# 2.Placing/open")')
    found = Code("", quoted, dict(origins_of(quoted, ORIGINAL).of), "")
    assert found.origin_of(quoted.splitlines().index('  mine("# 2.Placing/open")') + 1) == "2.Placing/open"


def test_a_comment_behind_code_is_none_of_it() -> None:
    said = TEXT.replace("movel(a)", "movel(a)  # 1.Grasping/close").replace("open(3)", "open(3)  # mine")
    assert list(origins_of(said, ORIGINAL).of.values()) == [*ORIGINAL.origins.values(), ""]
