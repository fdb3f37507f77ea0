"""A rollout as a file: one .npz of numbers and text, nothing that is executed when it is read."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from msgspec import to_builtins

from .errors import UserError
from .rollout import Message, Rollout, Touch
from .world import World

_ARRAYS = ("times", "joints", "wrench", "opening", "lines")


def save_rollout(rollout: Rollout, path: Path) -> None:
    """Write a rollout. The world is not written: whoever reads it has its file."""
    import numpy as np

    pairs = sorted({(t.a, t.b) for touches in rollout.touches for t in touches})
    number = {pair: k for k, pair in enumerate(pairs)}
    rows = [
        (k, number[t.a, t.b], t.force, t.lift) for k, touches in enumerate(rollout.touches) for t in touches
    ]  # fmt: skip
    header = {
        "effector": rollout.effector, "outcome": rollout.outcome, "reason": rollout.reason, "extra": rollout.extra,
        "messages": [to_builtins(m) for m in rollout.messages], "pairs": pairs, "poses": list(rollout.poses),
        "values": {name: values.tolist() for name, values in rollout.values.items()},
        "grains": list(rollout.grains), "sizes": rollout.sizes, "seen": rollout.seen,
    }  # fmt: skip
    arrays: dict[str, Any] = {name: getattr(rollout, name) for name in _ARRAYS}
    if rollout.force is not None:
        arrays["force"] = rollout.force
    poses = {f"pose{k}": rows for k, rows in enumerate(rollout.poses.values())}
    poses |= {f"grains{k}": rows for k, rows in enumerate(rollout.grains.values())}
    with path.open("wb") as file:
        np.savez(file, header=json.dumps(header), touches=np.array(rows).reshape(-1, 4), **arrays | poses)


def load_rollout(path: Path, world: World) -> Rollout:
    """Read what ``save_rollout`` wrote.

    Args:
        world: at the start.

    Raises:
        UserError: the file is missing or damaged.
    """
    import zipfile

    import numpy as np

    try:
        with np.load(path, allow_pickle=False) as file:
            data: dict[str, Any] = {name: file[name] for name in file.files}
        header = json.loads(str(data["header"]))
        return _rollout(header, data, world)
    except (OSError, ValueError, KeyError, IndexError, TypeError, zipfile.BadZipFile) as error:
        raise UserError(f"'{path}' holds no recorded run ({error}); run 'cramlite execute --out' again.") from error


def _rollout(header: dict[str, Any], data: dict[str, Any], world: World) -> Rollout:
    import numpy as np

    touches: list[list[Touch]] = [[] for _ in data["times"]]
    for sample, pair, force, lift in data["touches"].tolist():
        a, b = header["pairs"][int(pair)]
        touches[int(sample)].append(Touch(a, b, force, lift))
    return Rollout(
        world=world,
        effector=header["effector"],
        poses={name: data[f"pose{k}"] for k, name in enumerate(header["poses"])},
        touches=tuple(map(tuple, touches)),
        messages=tuple(Message(**m) for m in header["messages"]),
        outcome=header["outcome"],
        reason=header["reason"],
        extra=header["extra"],
        values={name: np.array(values) for name, values in header.get("values", {}).items()},
        grains={name: data[f"grains{k}"] for k, name in enumerate(header.get("grains", ()))},
        sizes={name: tuple(size) for name, size in header.get("sizes", {}).items()},
        seen=header.get("seen", {}),
        force=data.get("force"),
        **{name: data[name] for name in _ARRAYS},
    )
