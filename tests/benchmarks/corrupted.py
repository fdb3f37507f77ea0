"""Do the validators refuse programs that do harm, and pass those that do none? A corpus of edited programs.

    python tests/benchmarks/corrupted.py --rules open --work runs/corrupted
    python tests/benchmarks/corrupted.py --fixed

Programs of nineteen bases, each resolved first, are edited by rules that were written from the tasks' meaning, without a look at the
validators. An oracle reads the tracks of each run: a bad program counts only if it ran to its end and did the harm that its rule means, a
harmless one only if everything ended as before. The rules that are "sealed" are judged once, when nobody mends validators any more. What an
earlier run with the same folder answered is not asked again; take another folder for other validators.
"""

from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

import msgspec
from corruption.bases import BASES
from corruption.cases import RULES, cases, fixed
from corruption.judging import UNCHANGED, Answer, answers, distinct
from corruption.table import numbers, page
from figure import add_figure, write

HERE = Path(__file__).parent


def names(options: argparse.Namespace) -> list[str]:
    """Names of the cases to be judged: each base program unchanged, and its edited programs."""
    asked = fixed() if options.fixed else tuple(cases(RULES[options.rules], options.seed))
    of_base = (c for c in asked if not options.base or c.base in options.base)
    chosen = distinct((c for c in of_base if not options.rule or c.rule.name in options.rule), options.work)
    return [*(f"{UNCHANGED}/{b}/0" for b in dict.fromkeys(c.base for c in chosen)), *(c.name for c in chosen)]


def record(options: argparse.Namespace, found: list[Answer]) -> bytes:
    """Write down what was asked, of which code, and every answer."""
    commit = subprocess.run(
        ["git", "-C", str(HERE), "rev-parse", "HEAD"], capture_output=True, text=True, check=False
    ).stdout.strip()
    facts = {
        "commit": commit, "seed": options.seed, "rules": "fixed" if options.fixed else options.rules,
        "seen": not any(a.sealed for a in found),
        "cpu_seconds": sum(a.seconds for a in found), "answers": found,
    }  # fmt: skip
    return msgspec.json.format(msgspec.json.encode(facts))


def main() -> None:
    """Judge the corpus and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rules", choices=sorted(RULES), default="open")
    parser.add_argument("--fixed", action="store_true", help="only the forty of the test suite")
    parser.add_argument(
        "--base", action="append", choices=[b.name for b in BASES], help="only this one; may be given several times"
    )
    parser.add_argument("--rule", action="append", help="only this one; may be given several times")
    parser.add_argument("--seed", type=int, default=1, help="of the numbers in the edits")
    parser.add_argument(
        "--work", type=Path, default=Path("runs/corrupted"), help="folder for resolved bases and answers"
    )
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, help="write all answers to this JSON file")
    add_figure(parser)
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    wanted = names(options)
    found = []
    for one in answers(wanted, options.rules, options.seed, options.work, options.workers):
        found.append(one)
        print(
            f"{len(found)} of {len(wanted)}: {one.case}: {'passed' if one.passed else one.error or 'refused'}",
            flush=True,
        )
    print(page([a for a in found if not a.case.startswith(UNCHANGED)]))
    print(
        "\n".join(
            f"base refused: {a.base}: {a.reasons}" for a in found if a.case.startswith(UNCHANGED) and not a.passed
        )
    )
    cpu = sum(a.seconds for a in found)
    write(options, numbers([a for a in found if not a.case.startswith(UNCHANGED)]), f"seed {options.seed}", cpu)
    if options.out:
        options.out.write_bytes(record(options, found))


if __name__ == "__main__":
    main()
