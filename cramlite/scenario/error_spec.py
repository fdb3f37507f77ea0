"""Error models and proofs in scenario files: keys that are absent keep their defaults."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

from msgspec.structs import fields, replace
from pydantic import AfterValidator, Field, create_model

from ..base.quantities import Angle, Force, Length, Time
from ..base.spec import Spec
from ..model.sensor_errors import SensorErrors
from ..model.twins.error_model import ErrorModel, PoseError, declared
from ..model.twins.error_sources import FURTHEST, WIDEST, ErrorSource, Size
from ..model.twins.proof_doubts import MOST_TWINS, ProofDoubts


class PoseErrorSpec(Spec):
    """Error of a pose: in position [m] and in angle [rad]."""

    position: Length = Field(default=0.0, ge=0, le=FURTHEST)
    angle: Angle = Field(default=0.0, ge=0, le=WIDEST)

    def error(self) -> PoseError:
        """Return the pose error that the keys ``position`` and ``angle`` state."""
        return PoseError(self.position, self.angle)


class ThingErrorSpec(PoseErrorSpec):
    """Pose error of one thing."""

    thing: str


TYPES: dict[str, Any] = {"share": float, "rate": float, "length": Length, "angle": Angle, "force": Force, "time": Time}
"""Type of an error model's key in a scenario file, by the kind of its ``Size``."""


def keys_of(model: type[ErrorModel]) -> dict[str, Any]:
    """Return the keys that files may have for an error model, as optional fields of a specification."""
    keys: dict[str, Any] = {}
    declarations = declared(model)
    for name, source in ((f.name, declarations[f.name]) for f in fields(model) if f.name in declarations):
        sizes = {key: size for key, (_, size) in source.keys.items()} or ({name: source.size} if source.size is not None else {})
        pair = isinstance(source.nothing, tuple)
        keys |= {key: _pair(size) if pair else _key(size) for key, size in sizes.items()}
        if not sizes:
            keys[name] = (tuple[ThingErrorSpec, ...], ()) if isinstance(source.nothing, Mapping) else (PoseErrorSpec | None, None)
    return keys | {"scale": _key(Size("rate", 100))}


def _key(size: Size) -> Any:
    most: dict[str, Any] = {"lt" if size.kind == "share" else "le": size.most} if size.most < math.inf else {}
    return TYPES[size.kind] | None, Field(default=None, ge=0, **most)


def _pair(size: Size) -> Any:
    def in_order(ends: tuple[float, float]) -> tuple[float, float]:
        if not 0 <= ends[0] <= ends[1] <= size.most:
            raise ValueError(f"write the lowest and the highest {size.kind}, in this order, from 0 to {size.most:g}")
        return ends

    return Annotated[tuple.__class_getitem__((TYPES[size.kind],) * 2), AfterValidator(in_order)] | None, None


class ErrorSpec(create_model("ErrorKeys", __base__=Spec, **keys_of(ErrorModel))):  # type: ignore[misc]
    """Keys of an error model in files (``cramlite.model.ErrorModel``); an absent key keeps its value."""

    def errors(self, before: ErrorModel, sensor: SensorErrors) -> ErrorModel:
        """Return an error model with the changes that the scenario file states.

        Args:
            before: what is not written.
            sensor: of the robot; what is not written of the sensor, unless ``before`` says it.
        """
        before = replace(before, sensor=before.sensor or sensor)
        changes = {name: self._with_written(name, source, getattr(before, name)) for name, source in declared(type(before)).items()}
        return replace(before, **changes, scale=before.scale if self.scale is None else self.scale)

    def _with_written(self, name: str, source: ErrorSource, before: Any) -> Any:
        """Return the value of one field of an error model, with the changes that the file states."""
        if source.keys:
            return replace(before, **{a: v for key, (a, _) in source.keys.items() if (v := getattr(self, key)) is not None})
        said = getattr(self, name)
        if isinstance(said, PoseErrorSpec):
            return said.error()
        return {**before, **{t.thing: t.error() for t in said}} if isinstance(before, Mapping) else before if said is None else said


class ProofSpec(Spec):
    """Proof that a program must stand: the number of twins, the share of all runs that must succeed, and the
    twins' errors."""

    twins: int | None = Field(default=None, ge=0, le=MOST_TWINS)
    at_least: float = Field(default=ProofDoubts().at_least, ge=0, le=1)
    errors: ErrorSpec = ErrorSpec()
