"""Do two checkouts give the same programs, verdicts and decisions?

    python tests/benchmarks/same_outputs.py run CHECKOUT OUT        # `cramlite resolve` of every shipped scenario, seed 0,
                                                                    # and of fetch and hang with seeds 1 to 5
    python tests/benchmarks/same_outputs.py compare OUT_A OUT_B     # what differs, run by run

CHECKOUT has a virtual environment ``.venv``. Compared are exit code, the program's text, the verdict and the trace; words that
were renamed on purpose are given as ``--renamed OLD=NEW`` and fields that are new as ``--new-field NAME``.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

SEEDED = ("fetch_from_hanger", "hang_onto_hanger")


def runs(checkout: Path) -> Iterator[tuple[str, int]]:
    """Each scenario, by its path below ``scenarios``, and seed."""
    folder = checkout / "scenarios"
    for path in sorted(folder.glob("**/*.yaml")):
        if "demonstration" not in path.parts:
            yield path.relative_to(folder).with_suffix("").as_posix(), 0
    for seed in range(1, 6):
        yield from ((name, seed) for name in SEEDED)


def run_one(checkout: Path, out: Path, name: str, seed: int) -> None:
    folder = out / f"{name.replace('/', '__')}-{seed}"
    command = [str(checkout / ".venv/bin/cramlite"), "resolve", name, "--seed", str(seed), "--out", str(folder)]
    done = subprocess.run(
        command, cwd=checkout, capture_output=True, text=True, check=False, env={**os.environ, "OMP_NUM_THREADS": "1"}
    )
    log = out / f"{folder.name}.log"
    log.mkdir(parents=True, exist_ok=True)
    (log / "rc").write_text(f"{done.returncode}\n")
    (log / "out").write_text(done.stdout)
    (log / "err").write_text(done.stderr)


def read(out: Path, name: str, new_fields: set[str], renamed: list[tuple[str, str]]) -> dict[str, Any]:
    """Outputs of one run that are compared."""
    folder = out / name
    found: dict[str, Any] = {"exit code": (out / f"{name}.log" / "rc").read_text().strip()}
    for file in sorted(folder.glob("program.*")):
        found[file.name] = renaming(file.read_text(), renamed) if file.suffix != ".json" else None
    for file in ("program.json", "verdict.json", "trace.json", "plan.json"):
        if (folder / file).is_file():
            found[file] = without(json.loads(renaming((folder / file).read_text(), renamed)), new_fields)
    return found


def renaming(text: str, renamed: list[tuple[str, str]]) -> str:
    for old, new in renamed:
        text = text.replace(old, new)
    return text


def without(data: Any, fields: set[str]) -> Any:
    """JSON data without fields that only one of the two has."""
    if isinstance(data, dict):
        return {k: without(v, fields) for k, v in data.items() if k not in fields}
    return [without(v, fields) for v in data] if isinstance(data, list) else data


def first_difference(a: Any, b: Any, path: str = "") -> str:
    if isinstance(a, dict) and isinstance(b, dict):
        for key in sorted({*a, *b}):
            if a.get(key) != b.get(key):
                return first_difference(a.get(key), b.get(key), f"{path}/{key}")
    if isinstance(a, list) and isinstance(b, list):
        for number, (x, y) in enumerate(zip(a, b, strict=False)):
            if x != y:
                return first_difference(x, y, f"{path}/{number}")
        return f"{path}: {len(a)} entries against {len(b)}"
    return f"{path}: {str(a)[:150]!r} against {str(b)[:150]!r}"


def compare(a: Path, b: Path, new_fields: set[str], renamed: list[tuple[str, str]]) -> int:
    names = sorted({p.name.removesuffix(".log") for out in (a, b) for p in out.glob("*.log")})
    differing = 0
    for name in names:
        if not all((out / f"{name}.log" / "rc").is_file() for out in (a, b)):
            print(f"{name}: only in one")
            differing += 1
            continue
        one, other = (read(out, name, new_fields, renamed) for out in (a, b))
        if one != other:
            differing += 1
            for key in sorted({*one, *other}):
                if one.get(key) != other.get(key):
                    print(f"{name}: {key}: {first_difference(one.get(key), other.get(key))}")
    print(f"{len(names) - differing} of {len(names)} runs are the same")
    return 1 if differing or not names else 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("run", "compare"))
    parser.add_argument("first", type=Path)
    parser.add_argument("second", type=Path)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--renamed", action="append", default=[], metavar="OLD=NEW")
    parser.add_argument("--new-field", action="append", default=[], metavar="NAME")
    given = parser.parse_args()
    if given.what == "compare":
        pairs = [(old, new) for old, _, new in (r.partition("=") for r in given.renamed)]
        return compare(given.first, given.second, set(given.new_field), pairs)
    checkout, out = given.first.resolve(), given.second.resolve()
    with ThreadPoolExecutor(given.workers) as pool:
        list(pool.map(lambda run: run_one(checkout, out, *run), runs(checkout)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
