"""URScript for CB3 arms: no sensor in the flange, so no zero_ftsensor, which is e-Series only.

get_tcp_force and force read the external sensor once the controller was told so (enable_external_ft_sensor, the
sensor's URCap; URScript manual). The program then keeps the tare itself. The tare is a force in the base frame: it holds
for the orientation that it was taken in, as the guarded and force-controlled motions after it keep theirs.
"""

from __future__ import annotations

import re

PRELUDE = """
# ---- CB3 ----
# There is no zero_ftsensor here: the tare is kept by the program (base frame).
global tare = [0.0, 0.0, 0.0]
def net_force():
  local measured = get_tcp_force()
  return [measured[0] - tare[0], measured[1] - tare[1], measured[2] - tare[2]]
end
def zero_sensor():
  local measured = get_tcp_force()
  tare = [measured[0], measured[1], measured[2]]
end
"""
CALLS = {
    r"\bzero_ftsensor\(": "zero_sensor(",
    r"\bget_tcp_force\(\)": "net_force()",
    r"\bforce\(\)": "norm(net_force())",
    r"\bset_target_payload\(": "set_payload(",
}


def adapted(lines: list[str]) -> list[str]:
    """The lines of an e-Series program with CB3's calls, one for one, so that line numbers stay."""
    for old, new in CALLS.items():
        lines = [re.sub(old, new, line) for line in lines]
    return lines
