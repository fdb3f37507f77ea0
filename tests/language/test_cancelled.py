"""Sentences that ask the robot to do nothing more."""

from __future__ import annotations

import pytest

from cramlite.language.sentence import cancels


@pytest.mark.parametrize(("sentence", "stops"), [
    ("Stop moving. The task has been cancelled.", True), ("Stop!", True), ("please halt now", True), ("Cancel the task", True),
    ("put the mug on the plate", False), ("Stop, and put the mug on the plate", False), ("Stop. Put the mug on the plate.", False),
    ("open the drawer until it is stopped", False), ("It is cancelled", True), ("", False),
])  # fmt: skip
def test_what_only_stops_cancels(sentence: str, stops: bool) -> None:
    assert cancels(sentence) is stops
