"""Gripper from a file: its drives, its pads, and its model as MJCF text for the flange of an arm."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np

from cramlite.model import Floats, Gripper, HandFile, Linkage, Pose, Value
from cramlite.plugin import UserError, nearest

from ..scenes.source import Source
from .hand_drive import complete_drives
from .hand_guesses import guesses
from .hand_motion import Driven, driven, stroke
from .hand_spec import ROOT, hand_spec
from .model_text import numbers
from .pads import Pads, find_pads

SPEED = (0.010, 0.100)
"""Speed of pads where nobody states one [m/s]: that of a Franka Hand; a 2F-85 does 0.02 to 0.15."""
WEAKEST = 0.1
"""Lowest grip force as a share of the highest, unless stated."""
TURNING = 4  # condim of contacts with torsional friction
SECTIONS = ("default", "asset", "tendon", "equality", "actuator")
Mjcf = Callable[[str], tuple[str, str]]


class Hand(Value):
    """Gripper that was read from a file.

    Args:
        gripper: its tool centre point is in the frame of the flange.
        mjcf: name of the last link -> (body element for the flange, elements beside worldbody), as those of our own grippers.
        found: what was found, for people.
        notes: what was taken from elsewhere or changed, and what says another.
    """

    gripper: Gripper
    mjcf: Mjcf
    found: tuple[str, ...]
    notes: tuple[str, ...]


def read_hand(source: Source, stated: HandFile, last: int | None = None, link: Pose | None = None) -> Hand:
    """Read the gripper that a robot file, such as a URDF, describes.

    Args:
        stated: what the file does not say.
        last: id of the arm's last link, if the hand is in the arm's own file.
        link: of that link in the frame of the flange.

    Raises:
        UserError: it is no parallel gripper, or something that it needs is not stated; says what states it.
    """
    where = source.path
    spec = hand_spec(source, link or stated.at, last)
    named = _named(where, spec, stated)
    notes = complete_drives(where, spec)
    hand = driven(where, spec, named)
    controls, states, lengths = stroke(hand)
    pads = find_pads(where, hand.model, states, hand.pair, named)
    pads = _at_site(where, source, spec, pads, stated.tcp)
    linkage = _linkage(hand, pads, controls, states, lengths)
    linkage = _limited_stroke(where, linkage, stated.opening)
    force, more = _force(where, spec, hand, linkage, stated)
    friction = float(hand.model.geom_friction[pads.left[0], 0])
    own = _name_pads(spec, pads)
    turning = _resist_turning(own, stated.torsion)
    gripper = Gripper(
        where.name, (linkage.openings[-1], linkage.openings[0]), pads.size, pads.depth, float(hand.model.body_mass.sum()), pads.tcp,
        force, stated.speed or SPEED, linkage, friction,
    )  # fmt: skip
    text = spec.to_xml()
    owners = _owners(hand, pads)
    found = _found(where, hand, gripper, owners)
    guessed = guesses(gripper, owners, stated)
    return Hand(gripper, lambda wrist: _texts(text, gripper.tcp, wrist), found, (*guessed, *notes, *more, *turning))


def _owners(hand: Driven, pads: Pads) -> tuple[str, str]:
    """Names of the bodies that carry the pads, as the file has them."""
    left, right = (hand.model.body(int(hand.model.geom_bodyid[side[0]])).name for side in (pads.left, pads.right))
    return left.removeprefix(f"{ROOT}/"), right.removeprefix(f"{ROOT}/")


def _name_pads(spec: Any, pads: Pads) -> list[Any]:
    """Name the geoms of the pads as in every gripper of cramlite ("left_pad1" ...), and return them."""
    geoms, found = {int(g.id): g for g in spec.geoms}, []
    for side, ids in (("left", pads.left), ("right", pads.right)):
        for k, g in enumerate(ids, 1):
            geoms[g].name = f"{side}_pad{k}"
            found.append(geoms[g])
    return found


def _resist_turning(pads: Sequence[Any], torsion: float | None) -> tuple[str, ...]:
    """Give the pads the stated torsional friction; else note that the file gives them none."""
    for pad in pads if torsion is not None else ():
        pad.condim, pad.friction = max(int(pad.condim), TURNING), [pad.friction[0], torsion, pad.friction[2]]
    if all(int(pad.condim) >= TURNING for pad in pads):
        return ()
    said = "what touches each of them at one point turns in the hand; 'torsion' of 'gripper' states it"
    return (f"its pads have no torsional friction (condim 3): {said}",)


def _named(where: Path, spec: Any, stated: HandFile) -> list[list[int]] | None:
    """Return the geoms of each pad, if the scenario names the pads: a geom by its name, or all geoms of a body."""
    if stated.pads is None:
        return None
    model, found = spec.compile(), []
    bodies = {b.name.removeprefix(f"{ROOT}/"): int(b.id) for b in spec.bodies if b.name.startswith(f"{ROOT}/")}
    geoms = {g.info: int(g.id) for g in spec.geoms}
    for name in stated.pads:
        own = [geoms[name]] if name in geoms else [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) == bodies.get(name, -1)]
        if not own:
            raise UserError(
                f"{where}: 'pads' names '{name}', and no shape that collides is called so, nor a body that has one; "
                f"{nearest(name, [*filter(None, geoms), *bodies])}."
            )
        found.append(own)
    return found


def _at_site(where: Path, source: Source, spec: Any, pads: Pads, name: str) -> Pads:
    """Pads with the pinch point at the named site or body of the file; unchanged if none is named. The
    axes stay those of the pads."""
    if not name:
        return pads
    from msgspec.structs import replace

    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    places = {model.site(k).name.removeprefix(f"{ROOT}/"): data.site_xpos[k] for k in range(model.nsite)}
    places |= {model.body(k).name.removeprefix(f"{ROOT}/"): data.xpos[k] for k in range(2, model.nbody)}
    if name not in places:
        raise UserError(f"{where}: 'tcp' names '{name}', and the hand has no site or body of that name; {nearest(name, places)}.")
    return replace(pads, tcp=Pose.at(places[name], pads.tcp))


def _linkage(hand: Driven, pads: Pads, controls: Floats, states: Floats, lengths: Floats) -> Linkage:
    """Return the stroke of a hand as a table, from where its pads are farthest apart to where they meet."""
    gaps = np.array(pads.gaps)
    first = int(gaps.argmax())
    falling = [first]
    for k in range(first + 1, len(gaps)):
        if gaps[falling[-1]] - gaps[k] > 1e-4 and gaps[falling[-1]] > 0:
            falling.append(k)
    table = np.column_stack([gaps, controls, states, lengths])[falling]
    if table[-1, 0] < 0:  # between two samples the pads meet
        before, after = table[-2:]
        table[-1] = before + (after - before) * before[0] / (before[0] - after[0])
        table[-1, 0] = 0.0
    openings, controls, states, lengths = np.split(table, np.cumsum([1, controls.shape[1], states.shape[1]]), axis=1)
    slopes = np.gradient(lengths, openings[:, 0], axis=0)
    forces = np.repeat(1.0 / np.abs(slopes).sum(axis=1, keepdims=True), lengths.shape[1], axis=1)
    names = tuple(hand.model.joint(j).name for j in range(hand.model.njnt))
    weights = _weights(hand, np.sign(lengths[-1] - lengths[0]))
    return Linkage(
        _floats(openings[:, 0]), names, tuple(map(_floats, states)), _floats(weights), hand.names, tuple(map(_floats, controls)),
        tuple(map(_floats, forces)),
    )  # fmt: skip


def _weights(hand: Driven, signs: Floats) -> Floats:
    """Weight of each joint in the encoder reading of the hand's drives, signed so that the reading rises
    as the hand closes."""
    model, weights = hand.model, np.zeros(hand.model.njnt)
    for name, sign in zip(hand.names, signs, strict=True):
        a = model.actuator(name)
        target = int(a.trnid[0])
        if int(a.trntype[0]) == int(mujoco.mjtTrn.mjTRN_JOINT):
            weights[target] += sign
            continue
        start = int(model.tendon_adr[target])
        for k in range(start, start + int(model.tendon_num[target])):
            weights[int(model.wrap_objid[k])] += sign * float(model.wrap_prm[k])
    return weights


def _limited_stroke(where: Path, linkage: Linkage, opening: tuple[float, float] | None) -> Linkage:
    """Return a hand's stroke, cut to the range of openings that the user states."""
    if opening is None:
        return linkage
    from msgspec.structs import replace

    widest, narrowest = linkage.openings[0], linkage.openings[-1]
    low, high = opening
    if not narrowest - 1e-3 <= low < high <= widest + 1e-3:
        raise UserError(
            f"{where}: 'opening' of {1000 * low:g} to {1000 * high:g} mm is not within the fingers' range, {1000 * narrowest:.1f} to "
            f"{1000 * widest:.1f} mm."
        )
    ends = [min(high, widest), *(o for o in linkage.openings if low < o < high), max(low, narrowest)]
    ends = [o for k, o in enumerate(ends) if k == 0 or o < ends[k - 1]]

    def at(rows: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], ...]:
        columns = [np.interp(ends, linkage.openings[::-1], column[::-1]) for column in np.array(rows).T]
        return tuple(map(_floats, np.array(columns).T))

    return replace(
        linkage, openings=_floats(ends), positions=at(linkage.positions), controls=at(linkage.controls), forces=at(linkage.forces)
    )


def _force(where: Path, spec: Any, hand: Driven, linkage: Linkage, stated: HandFile) -> tuple[tuple[float, float], tuple[str, ...]]:
    """Return the lowest and highest grip force [N], as stated or as the file's drives exert it at half opening; and notes.

    Drives that are too weak for a stated force are made stronger.
    """
    mid = len(linkage.openings) // 2
    can = [_exerted(hand, linkage, k) for k in range(len(linkage.openings) - 1)]
    if stated.force is None:
        most = can[mid]
        weak = min(can[mid:])
        notes = [f"it grips with {most:.3g} N at half its opening, as the file's drives do; 'force' of 'gripper' can state another"]
        notes += [f"on narrow things its grip force is as low as {weak:.3g} N, as its drives are soft"] if weak < 0.8 * most else []
        if most <= 0:
            raise UserError(f"{where}: the hand's drives exert no force; state it by 'force' of 'gripper': [lowest, highest] in N.")
        return (WEAKEST * most, most), tuple(notes)
    low, high = stated.force
    if not 0 < low < high:
        raise UserError(f"{where}: 'force' of 'gripper' is {low:g} to {high:g} N; it must be two forces above 0, the lower one first.")
    changed = _strengthen(spec, hand, linkage, high)
    notes = [f"drive '{n.removeprefix(f'{ROOT}/')}' is weaker in the file than the stated {high:g} N: made as strong" for n in changed]
    return (low, high), tuple(notes)


def _exerted(hand: Driven, linkage: Linkage, k: int) -> float:
    """Return the grip force [N] of a hand's drives when they close on a thing as wide as entry ``k`` of the hand's table of openings."""
    found = []
    for a, name in enumerate(hand.names):
        act = hand.model.actuator(name)
        pull = abs(float(act.gainprm[0])) * abs(linkage.controls[-1][a] - linkage.controls[k][a])
        limit = float(act.forcerange[1]) if act.forcelimited[0] else pull
        found.append(min(pull, limit) / linkage.forces[k][a])
    return min(found)


def _strengthen(spec: Any, hand: Driven, linkage: Linkage, force: float) -> tuple[str, ...]:
    """Strengthen drives that are too weak for a grip force; controls and stiffness grow together, so
    control values keep their meaning."""
    changed = []
    for a, name in enumerate(hand.names):
        actuator, most = spec.actuator(name), force * max(row[a] for row in linkage.forces)
        soft = min(linkage.openings[0] / 4, 0.02)
        near = next(k for k, o in enumerate(linkage.openings) if o <= soft + linkage.openings[-1])
        pull = abs(float(actuator.gainprm[0]) * (linkage.controls[-1][a] - linkage.controls[near][a]))
        limited = bool(hand.model.actuator(name).forcelimited[0])
        if pull >= most and (not limited or actuator.forcerange[1] >= most):
            continue
        grow = max(1.0, most / pull) if pull > 0 else 1.0
        gain, bias = np.array(actuator.gainprm), np.array(actuator.biasprm)
        gain[0] *= grow
        bias[:3] *= (grow, grow, grow**0.5)
        actuator.gainprm, actuator.biasprm = gain, bias
        actuator.forcerange, actuator.forcelimited = [-most, most], True
        changed.append(name)
    return tuple(changed)


def _found(where: Path, hand: Driven, gripper: Gripper, owners: tuple[str, str]) -> tuple[str, ...]:
    low, high = gripper.opening
    drives = ", ".join(n.removeprefix(f"{ROOT}/") for n in hand.names)
    width, length = (1000 * v for v in gripper.pad)
    return (
        f"{where.name}: a hand that {drives} closes, from {1000 * high:.1f} to {1000 * low:.1f} mm; pads of {width:.0f} x {length:.0f} mm "
        f"on '{owners[0]}' and '{owners[1]}', with the file's friction of {gripper.friction:g}; {gripper.mass:.3g} kg",
        f"the pinch point is {1000 * gripper.tcp.position[2]:.0f} mm in front of the flange",
    )


def _texts(text: str, tcp: Pose, wrist: str) -> tuple[str, str]:
    """Return MJCF text of the hand's body, with the sites that cramlite needs, and of the elements outside of
    the worldbody."""
    root = ElementTree.fromstring(text)
    body = root.find("worldbody/body")
    assert body is not None
    body.set("gravcomp", "1")
    body.insert(0, ElementTree.Element("site", name="tcp", pos=numbers(tcp.position), quat=numbers(tcp.quaternion)))
    body.insert(0, ElementTree.Element("site", name="ft"))
    names = [b.get("name", "") for b in body.iter("body")]
    pairs = [*itertools.combinations(names, 2), *((wrist, n) for n in names)]
    skip = "".join(f'<exclude body1="{a}" body2="{b}"/>' for a, b in pairs)
    beside = "".join(ElementTree.tostring(s, encoding="unicode") for tag in SECTIONS for s in root.findall(tag))
    sensors = '<sensor><force name="ft_force" site="ft"/><torque name="ft_torque" site="ft"/></sensor>'
    return ElementTree.tostring(body, encoding="unicode"), f"{beside}<contact>{skip}</contact>{sensors}"


def _floats(values: Any) -> tuple[float, ...]:
    return tuple(float(v) for v in values)
