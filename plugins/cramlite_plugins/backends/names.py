"""Named values of a program's text: a motion's target is named after the task that it belongs to."""

from __future__ import annotations

import re

from msgspec import Struct, field


class Names(Struct):
    """Named values of a generated program (name -> text of the value), in the order of their first use."""

    values: dict[str, str] = field(default_factory=dict)

    def name(self, base: str, value: str) -> str:
        """Return a name for a value: ``base``, with a number at its end if a different value has that name
        already."""
        name, k = base, 1
        while name in self.values and self.values[name] != value:
            k += 1
            name = f"{base}_{k}"
        self.values[name] = value
        return name

    def of(self, origin: str, kind: str, value: str) -> str:
        """Return the name of a step's value, made of the step's origin and the kind of value
        ("grasping_1_approach_pose").

        The kind at its end keeps the name from being a keyword of the language.
        """
        return self.name(f"{identifier(origin)}_{kind}" if origin else f"unnamed_{kind}", value)


def identifier(origin: str) -> str:
    """Convert a step's origin to snake case, the task's number last: "3.InsertHole/close" is "insert_hole_3_close"."""
    text = re.sub(r"^(\d+)\.([^/]*)", r"\2_\1", origin)
    split = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", text)
    name = re.sub(r"[^A-Za-z0-9]+", "_", split).strip("_").lower()
    return name if name[:1].isalpha() else f"task_{name}"
