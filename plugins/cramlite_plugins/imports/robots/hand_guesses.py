"""Doubts about a hand from a file: its pads, pinch point and stroke where nobody states them."""

from __future__ import annotations

from cramlite.model import Gripper, HandFile


def guesses(gripper: Gripper, owners: tuple[str, str], stated: HandFile) -> tuple[str, ...]:
    """Return one sentence for each property of a hand that was guessed from its motion, with the key of ``gripper`` to state it by.

    Args:
        gripper: as it was read; its tool centre point is in the frame of the flange.
        owners: bodies that carry the pads.
        stated: what needs no finding.
    """
    width, length = (1000 * v for v in gripper.pad)
    low, high = (1000 * v for v in gripper.opening)
    at = ", ".join(f"{1000 * v:.0f}" for v in gripper.tcp.position)
    found = {
        "pads": f"its pads are taken to be faces of {width:.0f} x {length:.0f} mm on '{owners[0]}' and '{owners[1]}', which come nearest "
        "to each other; 'pads' of 'gripper' can name others",
        "tcp": f"its pinch point is taken to be the middle of its pads, at [{at}] mm in the frame of the flange; 'tcp' of 'gripper' "
        "can name another",
        "opening": f"its stroke is taken to be all that its drives do, {low:.1f} to {high:.1f} mm; 'opening' of 'gripper' "
        "can state another",
    }
    return tuple(said for key, said in found.items() if not getattr(stated, key))
