"""Results that are remembered for an object itself."""

from __future__ import annotations

from cramlite_plugins.shapes.itself import LAST, remembered


def test_the_last_objects_are_remembered_and_equal_ones_are_not_taken_for_them() -> None:
    asked: list[tuple[int, ...]] = []

    @remembered
    def total(of: tuple[int, ...]) -> int:
        """Return a sum."""
        asked.append(of)
        return sum(of)

    one, *others = ((1, k) for k in range(LAST + 1))
    twin = (*one[:1], *one[1:])
    assert total(one) == total(one) == total(twin) == 1
    assert len(asked) == 2
    for other in others:
        total(other)
    total(one)
    assert len(asked) == 2 + len(others) + 1
    assert total.__doc__ == "Return a sum."
