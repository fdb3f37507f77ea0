"""JSON text of values: structs, arrays and mappings; null for infinite numbers and NaN.

A struct has its fields, and beside them the properties that its class lists as ``TOLD``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from msgspec import Struct
from msgspec.structs import asdict

if TYPE_CHECKING:
    pass



def as_json(value: Any) -> str:
    """Return indented JSON of plain data, structs and arrays; null for infinite numbers and NaN."""
    return _json(value, 1)


def plain_json(value: Any) -> str:
    """Return JSON on one line, with the same values as ``as_json``."""
    return _json(value, None)


def _json(value: Any, indent: int | None) -> str:
    try:
        return json.dumps(value, indent=indent, default=_plain, allow_nan=False)
    except ValueError:  # rare, so that only then everything is looked at
        return json.dumps(_finite(value), indent=indent)


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v) for v in value]
    return value if value is None or isinstance(value, bool | int | str) else _finite(_plain(value))


def _plain(value: Any) -> Any:
    if isinstance(value, Struct):
        return asdict(value) | {name: getattr(value, name) for name in getattr(value, "TOLD", ())}
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    return str(value)
