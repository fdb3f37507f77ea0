"""Words for how a thing looks: its shape, its colours, and colours of small parts of it."""

from __future__ import annotations

from ...base.value import Value


class Looks(Value):
    """Words for how a thing looks, as people say them.

    Args:
        nouns: for its shape, such as "bottle".
        colours: of large shares of its surface, the largest share first.
        marks: further colours, of smaller shares, such as that of a cap.
    """

    nouns: tuple[str, ...] = ()
    colours: tuple[str, ...] = ()
    marks: tuple[str, ...] = ()
