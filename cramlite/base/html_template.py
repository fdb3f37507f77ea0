"""HTML pages from Jinja2 templates in which every value is escaped; an existing file is overwritten only if it is an HTML page."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import UserError

if TYPE_CHECKING:
    from jinja2 import Environment, Template


def html_template(text: str) -> Template:
    """Compile a Jinja2 template that escapes every value, because names come from people's files."""
    return _compiled(text)


def write_html(file: Path, page: str, *, make_folder: bool = False) -> None:
    """Write an HTML page to a file; an older page is overwritten.

    Args:
        make_folder: whether its folder is made if need be.

    Raises:
        UserError: it cannot be written, or the file holds something else, which stays.
    """
    try:
        if file.exists() and not file.read_bytes()[:100].lstrip().lower().startswith((b"<!doctype html", b"<html")):
            raise UserError(f"'{file}' exists and is no page of HTML; nothing was written. Choose another place.")
        if make_folder:
            file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(page, encoding="utf-8")
    except OSError as error:
        raise UserError(f"'{file}' cannot be written: {error.strerror or error}. Choose another place.") from None


@lru_cache(maxsize=64)
def _compiled(text: str) -> Template:
    return _environment().from_string(text)


@lru_cache(maxsize=1)
def _environment() -> Environment:
    from jinja2 import Environment, StrictUndefined

    return Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
