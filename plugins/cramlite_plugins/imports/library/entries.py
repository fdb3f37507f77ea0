"""The file of a library of object models: an entry for each model, by its name."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from pydantic import Field, ValidationError

from cramlite.model import Looks
from cramlite.plugin import Mass, Spec, UserError, explain_validation, load_yaml

HEAD = "# Known kinds, written by 'cramlite library add'. type, mass, fixed, up and looks may be edited.\nmodels:\n"


class LooksSpec(Spec):
    """Words by which people may call an object model, beside its name, as ``Looks`` has them."""

    nouns: tuple[str, ...] = ()
    colours: tuple[str, ...] = ()
    marks: tuple[str, ...] = ()

    @property
    def value(self) -> Looks:
        """Return the words."""
        return Looks(self.nouns, self.colours, self.marks)


class Entry(Spec):
    """Entry of an object model in a library's file.

    Args:
        thing: file of its shape; look: of its triangles and texture, beside the library's file.
        type: its class.
        mass: [kg]; None for the one of its shape.
        fixed: furniture.
        up: direction of its frame that usually points up; None where its shape says which.
        looks: words by which people may call it, beside its name.
        made_from: digest of the files that it was made from.
        told: what was printed of it when it was made.
    """

    thing: str
    look: str
    type: str
    mass: Mass | None = None
    fixed: bool = False
    up: str | None = None
    looks: LooksSpec = LooksSpec()
    made_from: str = ""
    told: dict[str, Any] = Field({})


def read_entries(file: Path) -> Mapping[str, Entry]:
    """Read the entries of the object models in a library's file.

    Raises:
        UserError: it has none, or an entry is wrong; with file and line.
    """
    data = load_yaml(file)
    models = data.get("models") if isinstance(data, dict) else None
    if not isinstance(models, dict) or not models:
        raise UserError(f"{file}:1: a library lists its object models under 'models'; make one with 'cramlite library add FOLDER'.")
    try:
        return {str(name): Entry.model_validate(value) for name, value in models.items()}
    except ValidationError as error:
        raise explain_validation(file, data, error, tuple(Entry.model_fields)) from error


def write_entries(file: Path, entries: Mapping[str, Entry]) -> None:
    """Write a library's file: the entries of its object models, in the order of their names."""
    rows = {n: entries[n].model_dump(exclude_none=True) for n in sorted(entries)}
    text = yaml.safe_dump(rows, sort_keys=False, width=110, allow_unicode=True)
    file.write_text(HEAD + "".join(f"  {line}\n" for line in text.splitlines()), encoding="utf-8")
