"""Views of the robot: pictures with the recognised things, and the belief after them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from cramlite.model import Value
from cramlite.plugin import ReportSection, hookimpl

from .filmstrip import as_uri
from .links import lines_of, look_name, steps_of
from .shared import fill

if TYPE_CHECKING:
    from cramlite import Finished, Percept, Picture
    from cramlite.model import Thing

QUALITY = 78
"""WebP quality of camera pictures: an overlay of 848 x 480 pixels takes 25 kB."""


class Seen(Value):
    """Recognised object of a picture: its number in the picture, class and confidence, or why it was left
    out.

    Args:
        name: under which it is believed; "" where it is not.
    """

    number: int
    name: str
    what: str
    where: str
    confidence: float
    reason: str
    answer: bool


class Shot(Value):
    """Picture from the robot's camera, with the object query that it answers.

    Recognised things, colours and depth are images as data URIs.
    """

    task: str
    query: str
    place: str
    overlay: str
    colour: str
    depth: str
    seen: tuple[Seen, ...]
    remarks: tuple[str, ...]


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("What it saw", 45, render, refused=True)


def render(done: Finished) -> str:
    """Render the report's pictures of the robot's camera as HTML."""
    look = done.setting.look
    if look is None:
        return ""
    products = done.engine.knowledge.products
    shots = [_shot(number, picture, products) for number, picture in enumerate(look.pictures, 1)]
    code = done.shown.candidate.code if done.shown is not None else None
    lines = lines_of(steps_of(code)) if code is not None else {}
    return fill("perception", shots=shots, lines=lines, estimates=look.estimates)


def _shot(number: int, picture: Picture, products: tuple[Thing, ...]) -> Shot:
    from cramlite import depth_image, overlay

    found, view = picture.perceived, picture.view
    drawn = overlay(found, view, products) if found is not None else view.rgb
    percepts = [(p, True) for p in found.answers] + [(p, False) for p in found.dropped] if found is not None else []
    place = ", ".join(f"{v:.2f}" for v in view.camera.position)
    return Shot(
        look_name(number) if picture.state is not None else "",
        str(found.query) if found is not None else "",
        f"{place} m" + ("" if picture.camera.mount is None else f", on the flange of '{picture.camera.mount}'"),
        as_uri(drawn, QUALITY),
        as_uri(view.rgb, QUALITY),
        as_uri(depth_image(view), QUALITY),
        tuple(_seen(p, answer) for p, answer in percepts),
        found.remarks if found is not None else (),
    )


def _seen(percept: Percept, answer: bool) -> Seen:
    pose = percept.value("pose")
    where = ", ".join(f"{v:.3f}" for v in pose.position) + " m" if pose is not None else ""
    reason = percept.dropped if not answer else "; ".join(percept.missing.values())
    if not reason and "pose" in percept.values:
        reason = f"pose by {percept.values['pose'].expert}: {percept.values['pose'].judged.reason}"
    what = str(percept.value("type") or "unknown")
    return Seen(percept.number, str(percept.value("instance") or ""), what, where, percept.confidence, reason, answer)
