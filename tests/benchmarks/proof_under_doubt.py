"""Costs of twins: the time of a nominal proof of a shipped scenario, and of one with twins.

    python tests/benchmarks/proof_under_doubt.py fetch_from_hanger --twins 8

The errors are so small that every run succeeds, and all of them are asked for, so that none is spared. CPU time is that of this
process and of those that run the twins; on quiet cores wall time is what is told beside it.
"""

from __future__ import annotations

import argparse
import resource
import time
from contextlib import closing

from figure import add_figure, value, write
from msgspec.structs import replace

from cramlite import Engine, find_scenario, read_scenario
from cramlite.model import ProofDoubts
from cramlite.model.twins.error_model import NO_ERRORS


def spent() -> float:
    """CPU seconds of this process, and of all its ended children."""
    own = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(u.ru_utime + u.ru_stime for u in own)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario")
    parser.add_argument("--twins", type=int, default=8)
    add_figure(parser)
    options = parser.parse_args()
    engine = Engine()
    reading = engine.read(read_scenario(find_scenario(options.scenario)))
    setting = engine.setting(reading, twins=0)
    errors = replace(NO_ERRORS, latency=(0.0, 1e-6))
    numbers = {}
    for count in (0, 0, options.twins):  # the first time plugins are imported
        wall, cpu = time.perf_counter(), spent()
        with closing(engine.resolve(reading, setting=replace(setting, doubts=ProofDoubts(count, 1.0, errors)))) as found:
            twins = next(found).verdict.twins
        said = twins.text if twins else "nominal"
        numbers[count] = value(options.scenario, spent() - cpu, "s", f"{count} twins, CPU", x=count)
        print(f"{count} twins: {time.perf_counter() - wall:.2f} s, {spent() - cpu:.2f} s of CPU time; {said}")
    write(options, numbers.values())


if __name__ == "__main__":
    main()
