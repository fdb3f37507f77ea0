"""The knowledge base of products: each entry of ``products.yaml`` is an object model, and known to perception."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from cramlite.model import Pose, Thing
from cramlite.plugin import ModelMaker, hookimpl, load_yaml


@lru_cache(maxsize=1)
def entries() -> Mapping[str, Mapping[str, Any]]:
    """Load the products: name -> model, class and parameters."""
    found: Mapping[str, Mapping[str, Any]] = load_yaml(Path(__file__).with_name("products.yaml"))
    return found


def _maker(name: str) -> ModelMaker:
    def make(*, name: str, pose: Pose, entry: str = name, **parameters: object) -> Thing:
        from msgspec.structs import replace

        from .products_and_fixtures import make as make_thing

        known = entries()[entry]
        thing = make_thing(known["model"], name, pose, {**known.get("with", {}), **parameters})
        return replace(thing, type=known.get("type", thing.type))

    def hang(thing: Thing, hanger: Thing, depth: float, yaw: float) -> Pose:
        from .products_and_fixtures import hung

        return hung(thing, hanger, depth, yaw)

    return ModelMaker(name, make, hang, product=True)


@hookimpl
def object_models() -> Iterable[ModelMaker]:
    """Declare every product as an object model."""
    return [_maker(name) for name in entries()]
