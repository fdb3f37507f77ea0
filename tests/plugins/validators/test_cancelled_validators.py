"""Validators that go through every sample of a run end soon after somebody asks them to."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from helpers.short_runs import good

from cramlite.base.pulse import Stopped, pulse
from cramlite.plugin import Candidate
from cramlite_plugins.validators.collision import bumps
from cramlite_plugins.validators.contact_force import touched_at
from cramlite_plugins.validators.grips import held_at, pressed_at


def _touched(made: Candidate) -> list[Any]:
    assert made.rollout is not None
    return list(touched_at(made.rollout, [""] * len(made.rollout.times)))


def _pressed(made: Candidate) -> list[Any]:
    assert made.rollout is not None
    return pressed_at(made.rollout)


def _held(made: Candidate) -> list[Any]:
    assert made.rollout is not None
    return held_at(made.rollout)


@pytest.mark.parametrize("long", [lambda made: list(bumps(made)), _touched, _pressed, _held])
def test_a_long_loop_of_a_validator_ends_when_it_is_asked_to(long: Callable[[Candidate], list[Any]]) -> None:
    assert isinstance(long(good()), list)
    with pytest.raises(Stopped), pulse(lambda: True):
        long(good())  # another run: what is told of one is kept
