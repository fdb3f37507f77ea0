"""Reader of JSON files with one or more documents: a document in each line, or an array of documents."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cramlite.plugin import UserError

#: Longest line [bytes]: a frame of 1,000 individuals takes about 0.1 MB.
MAX_LINE = 2**24
#: Largest array [bytes]: Python needs about ten times its size while it is read.
MAX_ARRAY = 2**25


def json_frames(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the documents of a file; lines are read one at a time.

    Raises:
        UserError: no JSON, too deep, or too large; names the line.
    """
    with path.open("rb") as file:
        first = file.readline(MAX_LINE)
    if isinstance(_tried(first), dict):
        yield from _lines(path)
        return
    if path.stat().st_size > MAX_ARRAY:
        raise UserError(
            f"{path}: a JSON array, or no JSON, of more than {MAX_ARRAY / 1e6:.0f} MB; write one frame a line, which is "
            "read without limit."
        )
    content = _document(path, 1, path.read_bytes())
    yield from content if isinstance(content, list) else [content]


def _tried(text: bytes) -> object:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None


def _lines(path: Path) -> Iterator[dict[str, Any]]:
    with path.open("rb") as file:
        number = 0
        while line := file.readline(MAX_LINE):
            number += 1
            if line.strip():
                yield _document(path, number, line)


def _document(path: Path, number: int, text: bytes) -> Any:
    try:
        return json.loads(text)
    except RecursionError:
        raise UserError(f"{path}:{number}: JSON nested too deeply; a frame of a world state has six levels.") from None
    except ValueError as error:
        line = number + getattr(error, "lineno", 1) - 1
        why = getattr(error, "msg", str(error))
        raise UserError(f"{path}:{line}: no JSON: {why}. A world state is one JSON document per frame.") from None
