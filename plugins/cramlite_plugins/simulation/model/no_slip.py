"""No-slip iterations of MuJoCo, left out while a vessel with loose contents is carried, and after these were poured out.

Their work grows with the square of the contacts, and twelve balls in a jug make thirty: with the iterations a run that pours takes half as
long again. Pads press without them on what holds contents, so these contacts are stiffer (``FIRM``). Where grains still roll in a vessel
that no robot holds, the iterations bring them to rest.
"""

from __future__ import annotations

import numpy as np

from .compile import Compiled
from .index import Data


class NoSlip:
    """Switch of MuJoCo's no-slip iterations: off while a robot touches grains or their vessel, directly or through things
    between them, unless grains move elsewhere alone.

    Args:
        compiled: the model whose option it sets.
        mount: of the robot.
    """

    def __init__(self, compiled: Compiled, mount: str) -> None:
        model = compiled.model
        self._options, self._iterations = model.opt, int(model.opt.noslip_iterations)
        self._robot = int(model.body_treeid[compiled.robots[mount].bodies[0]])
        filled = [t for t in compiled.things.values() if t.grains]
        self._grains = model.body_treeid[[b for t in filled for b, _ in t.grains]].tolist()
        self._vessels = [tree for tree in model.body_treeid[[t.body for t in filled]].tolist() if tree >= 0]

    def look(self, data: Data) -> None:
        """Set the number of no-slip iterations for the physics steps of the next control cycle."""
        if self._grains and self._iterations:
            self._options.noslip_iterations = 0 if self._carries(data) else self._iterations

    def _carries(self, data: Data) -> bool:
        if not data.nisland:
            return False
        islands = data.tree_island
        own = islands[self._robot]
        if own < 0:
            return False
        if np.any(islands[self._grains] == own):
            return True
        return bool(np.any(islands[self._vessels] == own) and np.all(data.tree_asleep[self._grains] >= 0))
