"""Figures: measured numbers with commit, seeds and machine; a file each, from which a page of the docs is
made."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError, model_validator

from ..base.rate import wilson_interval
from ..base.run_directory import write_whole
from ..base.spec import Spec
from ..base.yaml_file import explain_validation, load_yaml

DIGITS = 3
"""Number of decimal places of an interval's bounds."""
Seen = Literal["no", "partly", "yes"]
"""Statement whether a measurement's seeds had been run before it, so that choices may have been made on them."""


class Number(Spec):
    """Measured number of a figure: a rate with its 95 % Wilson interval, or a value with its unit.

    Args:
        what: row of the table that it stands in.
        part: column.
        hits, of: of a rate; the bounds follow from them and may be left out.
        value, unit: of anything else.
        low, high: bounds of its 95 % interval; None where none was worked out.
        x: place on the axis of the figure's plot; the row is the curve's name.
        note: what else is to be known of this number.
    """

    what: str
    part: str = ""
    hits: int | None = Field(default=None, ge=0)
    of: int | None = Field(default=None, ge=1)
    value: float | None = None
    unit: str = ""
    low: float | None = None
    high: float | None = None
    x: float | None = None
    note: str = ""

    @model_validator(mode="before")
    @classmethod
    def _bounds_follow(cls, data: Any) -> Any:
        if not isinstance(data, Mapping) or not _is_rate(data) or {"low", "high"} & data.keys():
            return data
        low, high = wilson_interval(data["hits"], data["of"])
        return {**data, "low": round(low, DIGITS), "high": round(high, DIGITS)}

    @model_validator(mode="after")
    def _one_kind(self) -> Number:
        if (self.hits is None) != (self.of is None) or (self.hits is None) == (self.value is None):
            raise ValueError("a number is given by 'hits' and 'of' (successes and trials), or by 'value'")
        if self.hits is None or self.of is None:
            return self
        if self.hits > self.of:
            raise ValueError(f"{self.hits} of {self.of} is no rate")
        low, high = (round(bound, DIGITS) for bound in wilson_interval(self.hits, self.of))
        if (self.low, self.high) != (low, high):
            raise ValueError(f"the Wilson interval of {self.hits} of {self.of} is {low} to {high}, not {self.low} to {self.high}")
        return self

    @property
    def height(self) -> float:
        """Value to plot: the share of hits if the number is a rate, else the plain value."""
        return self.hits / self.of if self.hits is not None and self.of else self.value or 0.0


def _is_rate(data: Mapping[str, Any]) -> bool:
    hits, of = data.get("hits"), data.get("of")
    return isinstance(hits, int) and isinstance(of, int) and 0 <= hits <= of and of > 0


class Published(Spec):
    """Number that others published about the same task.

    Args:
        who: system, and the part of the figure that it stands beside.
        said: the number, as it was published.
        given: what that system was given.
        source: where it was published.
    """

    who: str
    said: str
    given: str
    source: str = ""


class Plot(Spec):
    """Titles of the two axes of a diagram of measured numbers; a number without an ``x`` is not drawn."""

    x: str
    y: str


class Figure(Spec):
    """File of a measurement. ``title``, ``about``, ``given``, ``plot`` and ``beside`` are written by hand, the
    rest by the benchmark.

    Args:
        about: what was measured, and what has to be known to read the numbers.
        command: what repeats it.
        commit: of the code; None where it was not recorded.
        changed: the code had changes that were not committed.
        seeds: which; None where they were not recorded, or there are none.
        seen: whether they had been run before.
        machine: processor, cores, load, versions.
        cpu_s: CPU time of it all [s].
        given: what ours was given, where others' numbers stand beside.
    """

    title: str = Field(min_length=1)
    about: str = ""
    command: str
    commit: str | None = Field(default=None, pattern=r"^[0-9a-f]{7,40}$")
    changed: bool = False
    seeds: str | None = None
    seen: Seen | None = None
    machine: str | None = None
    cpu_s: float | None = None
    given: str | None = None
    plot: Plot | None = None
    numbers: tuple[Number, ...] = Field(min_length=1)
    beside: tuple[Published, ...] = ()


BY_HAND = ("title", "about", "given", "plot", "beside")
_ROWS = ("numbers", "beside")
_PARTS: dict[str, type[Spec]] = {"numbers": Number, "beside": Published, "plot": Plot}
_ONLY_IF = ("changed", "given", "plot", "about")


def read_figure(path: Path) -> Figure:
    """Read a file of measured numbers.

    Raises:
        UserError: not YAML, an unknown key, a wrong value, or an interval that does not belong to its rate: with file and line.
    """
    data: Any = load_yaml(path)
    try:
        return Figure.model_validate(data)
    except ValidationError as error:
        loc = next((p["loc"] for p in error.errors() if p["type"] == "extra_forbidden"), ())
        where = _PARTS.get(str(loc[0]), Figure) if len(loc) > 1 else Figure
        raise explain_validation(path, data, error, list(where.model_fields)) from error


def figure_text(figure: Figure) -> str:
    """Return the text of a file of measured numbers: YAML with one number on each line.

    Equal numbers and circumstances give equal texts.
    """
    data = figure.model_dump(mode="json")
    head = [f"{key}: {_flow(value)}" for key, value in data.items() if key not in _ROWS and (value or key not in _ONLY_IF)]
    rows = [line for key in _ROWS if data[key] for line in (f"{key}:", *(f"  - {_flow(_without_empty(row))}" for row in data[key]))]
    return "\n".join([*head, *rows]) + "\n"


def write_figure(path: Path, measured: Figure) -> Figure:
    """Write a file of measured numbers; hand-written parts of an existing one stay.

    Returns:
        What was written.

    Raises:
        UserError: the file that is there is no figure, or it cannot be written.
    """
    if path.is_file():
        known = read_figure(path)
        measured = measured.model_copy(update={name: getattr(known, name) for name in BY_HAND})
    write_whole(path, figure_text(measured))
    return measured


def _without_empty(row: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in row.items() if value not in (None, "")}


def _flow(value: Any) -> str:
    """A value in YAML's flow style, keys without quotes."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_flow(one)}" for key, one in value.items()) + "}"
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return json.dumps(value, ensure_ascii=False)
