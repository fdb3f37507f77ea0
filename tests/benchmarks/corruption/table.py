"""Tables of a run over the corpus: by class and by base, with intervals, and each wrong answer by its name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from cramlite.base.rate import Rate
from cramlite.experiment.figure import Number
from cramlite.experiment.measured import rate

from .judging import Answer

Answers = Sequence[Answer]


def _share(count: int, total: int) -> str:
    return Rate(count, total).text


def _rows(answers: Answers, key: Callable[[Answer], str]) -> Iterator[tuple[str, ...]]:
    for name in sorted({key(a) for a in answers}):
        of = [a for a in answers if key(a) == name]
        bad, good = ([a for a in of if a.counts and (a.group == "H") is harmless] for harmless in (False, True))
        refused = [a for a in bad if not a.passed]
        yield (
            name, _share(len(refused), len(bad)), _share(sum(a.right for a in refused), len(refused)),
            _share(sum(a.passed for a in good), len(good)), *_excluded(of),
        )  # fmt: skip


def _excluded(of: Iterable[Answer]) -> tuple[str, ...]:
    """Programs that halted by themselves, that did nothing (or, harmless, that did something), and that could not be judged."""
    of = tuple(of)
    halted = sum(bool(a.halted) for a in of)
    broken = sum(bool(a.error) for a in of)
    return str(halted), str(sum(not a.counts for a in of) - halted - broken), str(broken)


HEAD = ("", "bad refused", "of these with the right reason", "harmless passed", "halted", "did nothing", "broken")


def table(answers: Answers, first: str, key: Callable[[Answer], str]) -> str:
    """Write a table."""
    rows = [(first, *HEAD[1:]), ("---",) * len(HEAD), *_rows(answers, key), *_rows(answers, lambda _: "all")]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def wrong(answers: Answers) -> Iterator[str]:
    """Name each answer that is not as it should be."""
    for a in answers:
        if a.error:
            yield f"broken         {a.case}: {a.error}"
        elif a.counts and a.passed != (a.group == "H"):
            what = "false pass   " if a.passed else "false refusal"
            yield f"{what}  {a.case}: {a.oracle or '; '.join(a.reasons)}"
        elif a.counts and a.group != "H" and not a.right:
            yield f"wrong reason   {a.case}: {a.oracle}; but {'; '.join(a.reasons)}"


def page(answers: Answers) -> str:
    """Write all tables and names."""
    tables = table(answers, "class", lambda a: a.group), table(answers, "base", lambda a: a.base)
    return "\n\n".join((*tables, "\n".join(wrong(answers)) or "No answer is wrong."))


def numbers(answers: Answers) -> Iterator[Number]:
    """Give the rates of a figure: refused bad programs by class and in all, and passed harmless programs."""
    counted = [a for a in answers if a.counts]
    bad, harmless = ([a for a in counted if (a.group == "H") is kind] for kind in (False, True))
    for group in sorted({a.group for a in bad}):
        of = [a for a in bad if a.group == group]
        yield rate(f"class {group} refused", sum(not a.passed for a in of), len(of))
    for what, hits, total in (
        ("bad ones refused", sum(not a.passed for a in bad), len(bad)),
        ("refused with the right reason", sum(a.right for a in bad if not a.passed), sum(not a.passed for a in bad)),
        ("harmless ones passed", sum(a.passed for a in harmless), len(harmless)),
    ):
        if total:
            yield rate(what, hits, total)
