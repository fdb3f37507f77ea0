"""What tasks ask of the hand before they begin: that it is empty, or that it holds something."""

from __future__ import annotations

from cramlite import EARLIER_TASKS, Belief, Held, Unresolvable


def empty_hand(belief: Belief) -> None:
    """Nothing is held, so that something can be taken.

    Raises:
        Unresolvable: something is; earlier tasks are to blame.
    """
    if belief.held is not None:
        raise Unresolvable(f"the gripper already holds '{belief.held.thing}'", because=(EARLIER_TASKS,))


def what_is_held(belief: Belief, to_be: str) -> Held:
    """What is held, so that something can be done with it.

    Args:
        to_be: what, such as "let go".

    Raises:
        Unresolvable: nothing is; earlier tasks are to blame.
    """
    if belief.held is None:
        raise Unresolvable(f"nothing is held that could be {to_be}", because=(EARLIER_TASKS,))
    return belief.held
