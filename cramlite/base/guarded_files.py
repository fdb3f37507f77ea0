"""Safe reading of files from unknown sources: size, nesting and XML entities are limited before a parser sees a file.

Parsers behind these guards (MuJoCo's, rdflib's, NumPy's) trust what a file says of its own size. ``defusedxml`` guards Python's own XML
parsers alone, and refuses the harmless entities that event logs declare.
"""

from __future__ import annotations

import io
import json
import math
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.parsers import expat
from zipfile import BadZipFile, ZipFile

from .errors import UserError

if TYPE_CHECKING:
    from numpy.typing import NDArray

MOST_ENTITIES, LONGEST_ENTITY = 64, 300
"""Limits on the number of entities that an XML file declares and on the length of each [characters]. Event logs declare six, which are
namespaces of at most 60 characters."""
DEEPEST = 500
"""Largest nesting depth of XML elements, the limit of tinyxml2, the parser of MuJoCo."""
MOST_TEXT = 2**26
"""Largest number of characters in the attributes and text of an XML file, after its entities are expanded."""
Attributes = Mapping[str, str]
Visit = Callable[[int, str, Attributes | None], None]
"""Function that is called with line, name and attributes of each XML element; attributes are None at its end."""
_COMMENT = re.compile(r"<!--(.*?)-->", re.DOTALL)


def check_file(path: Path, most: int) -> None:
    """Check that a path leads to a regular file of at most some number of bytes.

    A device or a pipe would be read for ever.

    Raises:
        UserError: it is not; says what would be right.
    """
    try:
        size = path.stat().st_size
    except OSError as error:
        raise UserError(f"{path}: cannot be read: {error.strerror}.") from error
    if not path.is_file():
        what = "a folder" if path.is_dir() else "a device or a pipe"
        raise UserError(f"{path}: this is {what}, and a file is needed.")
    if size > most:
        raise UserError(f"{path}: {size / 1e6:.1f} MB; files of this kind have at most {most / 1e6:g} MB. Split or simplify it.")


def check_xml(path: Path, content: str | bytes, visit: Visit | None = None) -> None:
    """Parse an XML text with harmless entities only, nested no deeper than ``DEEPEST``; no other file is
    opened.

    Args:
        path: of the file, which errors name.
        content: of the file. In text "--" within comments is let pass, as most readers do; bytes are decoded as they say themselves.
        visit: is told each element.

    Raises:
        UserError: it is no XML; an entity is external, nested, or long; it is nested too deeply, or too long; with file and line.
    """
    text = content if isinstance(content, bytes) else _bytes(content)
    lines = len(text) - len(text.lstrip(b"\n"))
    parser = expat.ParserCreate(None if isinstance(content, bytes) else "utf-8")
    state = _State(path, visit or (lambda *_: None), lambda: int(parser.CurrentLineNumber) + lines)
    parser.buffer_text = True
    parser.EntityDeclHandler = state.entity
    parser.StartElementHandler, parser.EndElementHandler = state.start, state.end
    parser.CharacterDataHandler = state.count
    try:
        parser.Parse(text[lines:], True)
    except expat.ExpatError as error:
        raise UserError(f"{path}:{error.lineno + lines}: this is not XML: {expat.ErrorString(error.code)}; correct the XML.") from None


def _bytes(text: str) -> bytes:
    """Encode an XML text as UTF-8, without the byte order mark and the blanks at its start.

    Line breaks at its start are kept, so that line numbers stay true.

    Hyphens inside comments become equals signs.
    """
    start = text.lstrip("\ufeff \t\r\n")
    marked = _COMMENT.sub(lambda found: f"<!--{found[1].replace('-', '=')}-->", start)
    return b"\n" * text[: len(text) - len(start)].count("\n") + marked.encode("utf-8", "replace")


class _State:
    """State of an XML parse: counts of depth, entities and characters so far, each with its limit."""

    def __init__(self, path: Path, visit: Visit, line: Callable[[], int]) -> None:
        self.path, self.visit, self.line = path, visit, line
        self.depth = self.entities = self.characters = 0

    def refuse(self, what: str) -> UserError:
        return UserError(f"{self.path}:{self.line()}: {what}")

    def entity(self, name: str, parameter: bool, value: str | None, *_: object) -> None:
        self.entities += 1
        harmful = parameter or value is None or "&" in value or "%" in value or len(value) > LONGEST_ENTITY
        if harmful or self.entities > MOST_ENTITIES:
            raise self.refuse(
                f"entity '{name}' is nested, external, longer than {LONGEST_ENTITY} characters, or one of more than {MOST_ENTITIES}, "
                "which could exhaust memory or read other files. Only abbreviations such as those of namespaces are accepted."
            )

    def start(self, name: str, attributes: dict[str, str]) -> None:
        self.depth += 1
        if self.depth > DEEPEST:
            raise self.refuse(f"elements are nested more than {DEEPEST} deep; no file of this kind needs that.")
        for key, value in attributes.items():
            self.count(key + value)
        self.visit(self.line(), name, attributes)

    def end(self, name: str) -> None:
        self.depth -= 1
        self.visit(self.line(), name, None)

    def count(self, text: str) -> None:
        self.characters += len(text)
        if self.characters > MOST_TEXT:
            raise self.refuse(f"with its entities expanded the text has more than {MOST_TEXT} characters.")


def check_json_ld(path: Path, text: str) -> None:
    """Check that a JSON-LD text defines its contexts inline: rdflib would open any file or address that a context names.

    Raises:
        UserError: it names one, or is no JSON, or nested too deeply.
    """
    try:
        open_: list[object] = [json.loads(text)]
    except (ValueError, RecursionError):
        raise UserError(f"{path}:1: cannot be read as JSON-LD: no JSON, or nested too deeply.") from None
    while open_:
        node = open_.pop()
        if isinstance(node, dict):
            for key, value in node.items():
                values = value if isinstance(value, list) else [value]
                if key in ("@context", "@import") and (named := next((v for v in values if isinstance(v, str)), None)):
                    raise UserError(f"{path}:1: its {key} is in another file or at an address ({named:.80}); write its content here.")
            open_ += node.values()
        elif isinstance(node, list):
            open_ += node


def read_arrays(path: Path, most: int) -> dict[str, NDArray[Any]]:
    """Read the arrays of a NumPy archive (.npz) without unpickling.

    An array whose header claims more bytes than the file holds is refused before memory is allocated.

    Args:
        most: bytes of all arrays together, unpacked.

    Raises:
        UserError: it is no such archive, is damaged, would take more, or has an array of objects.
    """
    import zlib

    try:
        check_file(path, most)
        with ZipFile(path) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
            if size > most:
                raise ValueError(f"unpacked, the archive would take {size / 1e9:.1f} GB, and {most / 1e9:.1f} GB are allowed")
            return {name.removesuffix(".npy"): _array(archive.read(name), name) for name in archive.namelist()}
    except (OSError, ValueError, KeyError, EOFError, BadZipFile, zlib.error, NotImplementedError, RuntimeError, MemoryError) as error:
        why = " ".join(str(error).split())[:200] or type(error).__name__
        raise UserError(f"{path}: this is no NumPy archive (.npz), or a damaged one: {why}.") from error


def _array(content: bytes, name: str) -> NDArray[Any]:
    """Return the array of a .npy file; refuse Python objects, and a header that claims more bytes than the
    file has."""
    import numpy as np

    file = io.BytesIO(content)
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(file)
    if dtype.hasobject:
        raise ValueError(f"the array '{name}' has Python objects (pickles), which are not read")
    if math.prod(shape) * dtype.itemsize > len(content):
        raise ValueError(f"the array '{name}' has the shape {shape} by its header, but only {len(content)} bytes")
    file.seek(0)
    return np.lib.format.read_array(file, allow_pickle=False)
