"""Access to the hooks of plugins for episodes: reading, repair, writing, and detection of events in runs."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

from ..base.errors import DEFECTS, PluginError, UserError
from ..model.episode import Episode
from ..model.run.rollout import Rollout
from .protocols import EpisodeRepair
from .registry import Registry
from .validation import check_answer

KEPT = 4
"""Largest number of episodes, read from folders, that are kept in memory. A scenario that is resolved again has the same demonstration."""


class EpisodeHooks:
    """What plugins do with episodes: read, repair and write them, and detect events in runs; their answers
    are checked.

    Args:
        registry: whose plugins are asked.
    """

    def __init__(self, registry: Registry) -> None:
        self._registry = registry
        self._read: dict[tuple[tuple[Path, int, int], ...], Episode] = {}

    @cached_property
    def repairs(self) -> tuple[EpisodeRepair, ...]:
        """All repairs of episodes that plugins declare, in the order in which they are applied.

        Raises:
            PluginError: two plugins declare one name.
        """
        declared = self._registry.named("episode_repairs", "name").values()
        return tuple(sorted(declared, key=lambda r: r.order))

    def read(self, path: Path) -> Episode:
        """Read an episode with the first plugin that knows its format, and repair it. A folder is read once, until a file in it changes.

        Raises:
            UserError: no plugin reads its format, or it cannot be used.
            PluginError: the same, and a plugin that may have read it failed.
        """
        nobody = (
            f"'{path}' is in no format that a plugin reads (RobCoG event data, KnowRob mongodump, RDF, the mapping file of a table of "
            "poses); see 'cramlite plugins'."
        )
        key = _files(path) if path.is_dir() else ()
        if key in self._read:
            return self._read[key]
        found = self.repaired(self._answer("read_episode", nobody, path=path))
        if key:
            self._read = dict([*self._read.items(), (key, found)][-KEPT:])
        return found

    def repaired(self, episode: Episode) -> Episode:
        """Apply all repairs to an episode as it was recorded; a repair that fails changes nothing and is
        recorded as its plugin's fault.

        Returns:
            The very episode, if nothing had to be changed; else a new one with its ``repairs``.
        """
        for repair in self.repairs:
            episode = self._repaired(episode, repair)
        return episode

    def detect(self, rollout: Rollout, name: str) -> Episode:
        """Detect the events of a rollout, whether of a demonstration or of a program's run; repairs are not
        applied.

        Raises:
            UserError: no plugin detects events.
            PluginError: the one that should have failed.
        """
        nobody = f"No plugin detects the events of '{name}', and nothing can be recorded or judged without events; see 'cramlite plugins'."
        answer: Episode = self._answer("detect_events", nobody, name=name, rollout=rollout)
        return answer

    def write(self, episode: Episode, path: Path) -> Path:
        """Write an episode, and return the file or folder.

        Raises:
            UserError: no plugin writes to such a path, or it cannot be written.
            PluginError: the plugin that should have written it failed.
        """
        nobody = f"No plugin writes the episode '{episode.name}' to '{path}'; see 'cramlite plugins'."
        written: Path = self._answer("write_episode", nobody, path=path, episode=episode)
        return written

    def _repaired(self, episode: Episode, repair: EpisodeRepair) -> Episode:
        hook = "episode_repairs"
        try:
            answer = repair.repair(episode)
            check_answer(hook, answer)
            return answer
        except UserError:
            raise
        except DEFECTS as error:
            self._registry.fault(self._registry.owner(hook, repair.name), hook, repair.name, error)
            return episode

    def _answer(self, hook: str, nobody: str, **arguments: Any) -> Any:
        """Call a hook of all plugins in turn, and return the first answer that is not None.

        If every answer is None, the error names the plugins that failed.
        """
        answer = self._registry.first(hook, **arguments)
        if answer is not None:
            return answer
        about = str(next(iter(arguments.values())))
        failed = [str(f) for f in self._registry.faults if (f.hook, f.designator) == (hook, about)]
        if failed:
            raise PluginError(f"{nobody} Failed: {'; '.join(failed)}.")
        raise UserError(nobody)


def _files(folder: Path) -> tuple[tuple[Path, int, int], ...]:
    """Files below a folder, each with when it was changed [ns] and its size."""
    found = ((path, path.stat()) for path in sorted(folder.resolve().rglob("*")) if path.is_file())
    return tuple((path, stat.st_mtime_ns, stat.st_size) for path, stat in found)
