"""Files of a recorded execution."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import UserError
from ..base.json_text import as_json
from ..model.run.rollout import save_rollout
from .texts import rollout_json, warn_of

if TYPE_CHECKING:
    from ..model.episode import Event
    from ..model.run.rollout import Rollout


def write_run(
    out: Path, rollout: Rollout, name: str, knowledge: Any, *, episode: bool, events: Sequence[Event] = ()
) -> None:
    """Write a recorded run into a folder: result, recording, world and episode."""
    from msgspec import json
    from msgspec.structs import replace

    try:
        out.mkdir(parents=True, exist_ok=True)
        (out / "execution.json").write_text(as_json(rollout_json(rollout)), encoding="utf-8", newline="\n")
        save_rollout(rollout, out / "rollout.npz")
        (out / "world.json").write_bytes(json.format(json.encode(rollout.world), indent=1))
    except OSError as error:
        raise UserError(f"'{out}' cannot be written: {error.strerror}.") from error
    if episode:
        found = knowledge.episodes.detect(rollout, name)
        whole = replace(found, events=tuple(sorted((*found.events, *events), key=lambda e: e.start)))
        knowledge.episodes.write(whole, out / "episode")
        warn_of(knowledge.registry.faults)
