"""Effects of errors of size, centre of mass and lean on twins: the same programs in the same twins, with these three and without.

    python tests/benchmarks/shape_errors.py [SCENARIO ...] [--twins 9] [--seed 0]

Each scenario is resolved nominally, and its program runs in so many twins twice. Each source of errors draws by itself, so that the two
twins of a number differ in nothing else. None of these twins was seen in a search: their seeds are of a family of their own.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from figure import add_figure, rate, value, write
from msgspec.structs import replace

from cramlite import Engine, find_scenario, read_scenario
from cramlite.engine.proof.proof import text_that_runs
from cramlite.engine.proof.twin_proof import Doubtful, twin_seed
from cramlite.experiment.figure import Number
from cramlite.model import ErrorModel, ProofDoubts

SCENARIOS = (
    "place_on_shelf", "tasks/placing_inside", "fetch_from_hanger", "hang_up_a_product", "tasks/pouring", "kitchen/into_drawer",
    "kitchen/lid_on_pot", "kitchen/small_into_basket", "kitchen/stack_of_four", "kitchen/bottle_on_rack",
)  # fmt: skip
Rows = dict[str, tuple[list[bool], list[bool]]]


def outcomes(engine: Engine, name: str, twins: int, seed: int) -> tuple[list[bool], list[bool]]:
    """Which twins succeed with all errors, and which without those of shapes."""
    scenario = read_scenario(find_scenario(name))
    nominal = engine.setting(scenario, seed=seed, twins=0)
    solution = next(engine.resolve(scenario, setting=nominal, seed=seed), None)
    if solution is None:
        raise SystemExit(f"{name} is not proven nominally with seed {seed}")
    text = text_that_runs(solution.candidate, nominal.backend)
    full = nominal.doubts.errors
    setting = replace(nominal, doubts=ProofDoubts(twins, 1.0, full))
    assert text is not None
    seeds = [twin_seed(seed, text.text, k, "shape errors") for k in range(1, twins + 1)]
    doubtful = Doubtful(solution.candidate, text, setting, engine.knowledge, engine.executors)
    return tuple(list(_passed(doubtful, seeds, e)) for e in (full, replace(full, size=0.0, centre=0.0, lean=0.0)))  # type: ignore[return-value]


def _passed(doubtful: Doubtful, seeds: list[int], errors: ErrorModel) -> Iterator[bool]:
    for said, _ in doubtful.runs((doubtful.twin(s, errors).world, s) for s in seeds):
        if said is not None:
            print(f"    {said.validator}: {said.reason[:140]}", flush=True)
        yield said is None


def numbers(rows: Rows) -> Iterator[Number]:
    """How many runs succeeded, of each scenario and of all, and in how many twins the two differ."""
    both = [(w, o) for full, without in rows.values() for w, o in zip(full, without, strict=True)]
    parts = {name: list(zip(*two, strict=True)) for name, two in rows.items()}
    for name, pairs in {**parts, "together": both}.items():
        yield rate(name, sum(w for w, _ in pairs), len(pairs), "with size, centre and lean")
        yield rate(name, sum(o for _, o in pairs), len(pairs), "without")
    yield value("together", sum(o and not w for w, o in both), "twins", "fail with them alone")
    yield value("together", sum(w and not o for w, o in both), "twins", "fail without them alone")


def main() -> None:
    """Print a line for each scenario, and write the figure if one is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenarios", nargs="*", default=SCENARIOS)
    parser.add_argument("--twins", type=int, default=9)
    parser.add_argument("--seed", type=int, default=0)
    add_figure(parser)
    options = parser.parse_args()
    engine, rows = Engine(), Rows()
    for name in options.scenarios or SCENARIOS:
        rows[name] = outcomes(engine, name, options.twins, options.seed)
        full, without = rows[name]
        print(f"{name}: with {sum(full)} of {len(full)}, without {sum(without)} of {len(without)}", flush=True)
    write(options, list(numbers(rows)), seeds=f"seed {options.seed}, twins 1 to {options.twins}")


if __name__ == "__main__":
    main()
