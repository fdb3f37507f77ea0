"""What a number that was drawn says of itself, and the bounds within which numbers are drawn."""

from __future__ import annotations

import pytest

from cramlite.model.twins.twin_drawing import LEAST, MM, Draw, Drawing


@pytest.mark.parametrize(("value", "size", "share"), [(3.0, 4.0, 0.75), (-1.0, 4.0, -0.25), (0.0, 0.0, 0.0)])
def test_a_share_is_of_the_largest_possible(value: float, size: float, share: float) -> None:
    assert Draw("poses", "block: x", value, size, "mm").share == share


def test_a_factor_is_never_so_low_that_nothing_is_left() -> None:
    drawing = Drawing(1.0, 1)
    drawn = [drawing.share("mass", "block: mass", 3.0) for _ in range(100)]
    assert min(drawn) == LEAST == 0.05 and max(drawn) > 2.0


def test_what_is_not_in_doubt_is_not_told() -> None:
    drawing = Drawing(1.0, 1)
    assert (
        drawing.number("poses", "block: x", 0.0, "mm", MM)
        == 0.0
        == drawing.between("latency", "late", (0.0, 0.0), "ms", MM)
    )
    assert drawing.draws == []
