"""Experiment files: demonstrations, worlds, errors of the twins, published numbers."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

from pydantic import Field, model_validator

from ...base.spec import Name, Spec
from ...base.value import Value
from ...base.yaml_file import line_of
from ...planning.search.budget import Budget, budget_from
from ...scenario.error_spec import ErrorSpec, ProofSpec
from ..experiment_file import ExperimentFile, read_spec


class SetSpec(Spec):
    """Set of demonstrations: ``count`` of each object; those of object number j have the seeds ``first`` +
    100 j + 0, 1, ...

    ``scenario`` stands for the experiment's own; ``short`` is how many of each object ``--short`` takes. With
    ``until_solved`` the candidates after the first that succeeds in execution are not tried: the set then says how many
    demonstrations are solved, and its rates over candidates are of those that were tried. ``budget`` goes before the
    experiment's own; its ``sequences`` are the candidates that are tried.
    """

    first: int = Field(ge=1)
    count: int = Field(default=10, ge=1, le=100)
    short: int = Field(default=2, ge=1)
    scenario: str | None = None
    until_solved: bool = False
    budget: dict[str, int] = Field(default_factory=dict)
    about: str = ""


class AblationSpec(Spec):
    """Ablation of an experiment: a replaced plugin, other rules, more candidates, or twins without errors."""

    about: str
    plugin: str | None = None
    rules: str | None = None
    candidates: int | None = Field(default=None, ge=1)
    twin: bool = True


class PublishedSpec(Spec):
    """Published counts of demonstrations with candidates, and of candidates by outcome; each list has one count for each object.

    The counts are in the order of ``objects``.
    """

    source: str
    gave_candidates: tuple[int, ...]
    candidates: tuple[int, ...]
    planned: tuple[int, ...]
    simulated: tuple[int, ...]
    executed: tuple[int, ...]


class ThresholdSpec(Spec):
    """Least shares that an experiment with ``--short`` must reach: of demonstrations solved, and of
    candidates planned, simulated and executed."""

    solved: float = Field(default=1.0, ge=0, le=1)
    planned: float = Field(default=0.0, ge=0, le=1)
    simulated: float = Field(default=0.0, ge=0, le=1)
    executed: float = Field(default=0.0, ge=0, le=1)


class ExperimentSpec(Spec):
    """Keys of an experiment file.

    ``product`` is the thing of the recording that the objects stand for; ``goal`` a relation that must hold at the end;
    ``validators`` those that say whether an execution succeeded; ``twin`` how far the worlds of executions are off, nothing
    where it says nothing; ``scales`` how many times as far, a further execution each; ``proof`` the doubts that a program must stand
    before, whose ``errors`` begin with those of ``twin``.
    """

    experiment: Name
    title: str
    scenario: str
    product: str
    goal: tuple[str, str, str]
    validators: tuple[str, ...]
    objects: dict[str, dict[str, Any]] = Field(min_length=1)
    sets: dict[str, SetSpec] = Field(min_length=1)
    twin: ErrorSpec
    scales: tuple[float, ...] = Field(default=(1.0,), min_length=1)
    proof: ProofSpec = ProofSpec(twins=0)
    budget: dict[str, int] = Field(default_factory=dict)
    most_candidates: int = Field(default=12, ge=1)
    ablations: dict[str, AblationSpec] = Field(default_factory=dict)
    thresholds: ThresholdSpec = ThresholdSpec()
    published: PublishedSpec | None = None

    @model_validator(mode="after")
    def _rising(self) -> ExperimentSpec:
        if any(b <= a for a, b in pairwise((0.0, *self.scales))):
            raise ValueError("'scales' are numbers above 0 that rise, such as [1, 2, 3]")
        return self

    @model_validator(mode="after")
    def _sets_apart(self) -> ExperimentSpec:
        taken: dict[int, str] = {}
        for name, one in self.sets.items():
            for seed in (one.first + 100 * j + n for j in range(len(self.objects)) for n in range(one.count)):
                if seed in taken:
                    raise ValueError(f"the sets '{taken[seed]}' and '{name}' share the seed {seed}; change 'first' of one")
                taken[seed] = name
        return self


class Demonstration(Value):
    """Demonstration to be recorded.

    Args:
        name: "O1-03": the object, and its number from 1.
        object: key of the experiment's objects.
        seed: of the person and their world; others are derived from it.
    """

    name: str
    object: str
    seed: int


class Experiment(ExperimentFile):
    """Experiment file that was read and checked."""

    spec: ExperimentSpec

    def choose(self, set_name: str) -> SetSpec:
        """Return the set of demonstrations of a given name.

        Raises:
            UserError: there is none of the name.
        """
        return self.named("set", set_name, self.spec.sets)

    def ablation(self, name: str | None) -> AblationSpec:
        """Return the ablation of a given name; without a name one that changes nothing.

        Raises:
            UserError: there is none of the name.
        """
        if name is None:
            return AblationSpec(about="nothing is taken away")
        return self.named("ablation", name, self.spec.ablations)

    def budget(self, set_name: str, without: str | None = None) -> Budget:
        """Return the budget of each demonstration of a set: the set's keys override the experiment's.

        Raises:
            UserError: there is no such set or ablation.
        """
        said = {"sequences": self.spec.most_candidates, **self.spec.budget, **self.choose(set_name).budget}
        left = self.ablation(without).candidates
        return Budget(**(said | ({"sequences": left} if left else {})))

    def demonstrations(self, set_name: str, *, short: bool = False) -> tuple[Demonstration, ...]:
        """Return the demonstrations of a set that are to be recorded, in order."""
        chosen = self.choose(set_name)
        count = min(chosen.short, chosen.count) if short else chosen.count
        return tuple(
            Demonstration(f"{name}-{n + 1:02}", name, chosen.first + 100 * j + n)
            for j, name in enumerate(self.spec.objects)
            for n in range(count)
        )


def read_experiment(path: Path) -> Experiment:
    """Read an experiment file.

    Raises:
        UserError: not YAML, an unknown key, or a wrong value: with file and line.
    """
    spec, data = read_spec(path, ExperimentSpec)
    for where, budget in ((), spec.budget), *((("sets", name), one.budget) for name, one in spec.sets.items()):
        budget_from(budget, lambda key, where=where: f"{path}:{line_of(data, (*where, 'budget', key))}")  # type: ignore[misc]
    return Experiment(path, spec)
