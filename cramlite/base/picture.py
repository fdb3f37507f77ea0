"""Pictures as bytes of an image file, and as data URIs for pages."""

from __future__ import annotations

import base64
from io import BytesIO
from typing import Any


def encoded(pixels: Any, kind: str, **options: Any) -> bytes:
    """Return a picture (height, width, 3) uint8 as the bytes of an image file.

    Args:
        kind: format as Pillow names it, such as "PNG".
        options: of that format.
    """
    from PIL import Image

    buffer = BytesIO()
    Image.fromarray(pixels).save(buffer, kind, **options)
    return buffer.getvalue()


def data_uri(picture: bytes, kind: str) -> str:
    """Return the bytes of an image file as a data URI; ``kind`` is its format, such as "PNG"."""
    return f"data:image/{kind.lower()};base64,{base64.b64encode(picture).decode()}"
