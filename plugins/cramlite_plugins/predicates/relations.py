"""Predicates on relations, from the states of an episode, and the hook that declares all shipped predicates.

Conditions of contact, support and grasp come from the states alone; they are three separate
relations: being grasped is not being supported. Motion comes from the tracks
(see motion.py), places from poses and shapes (see places.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING

from cramlite.plugin import Predicate, hookimpl

from . import attitudes, fluents, unknowns
from . import motion as motion_predicates
from . import places as place_predicates

if TYPE_CHECKING:
    from cramlite.plugin import Phase, Row


def all_predicates() -> tuple[Predicate, ...]:
    """Return every predicate of this package, for the hook ``predicates``."""
    return (
        *_of_states(),
        Predicate(
            "effector", 1, effector, doc="The hand or gripper that acts.", cost=0, timeless=True, complete=True,
            static=fluents.is_effector, unknown=unknowns.no_effector,
        ),
        Predicate(
            "isa", 2, isa, doc="Thing is of a class.", cost=3, timeless=True, static=fluents.is_a, unknown=unknowns.no_class, classes=(1,)
        ),
        Predicate(
            "has",
            2,
            has,
            doc="Thing is of a class, has a part of it, or its own class says it has one.",
            cost=3,
            timeless=True,
            static=fluents.has,
            unknown=unknowns.no_class,
            classes=(1,),
        ),
        Predicate(
            "part", 2, part, doc="Thing has part.", cost=3, timeless=True, complete=True, static=fluents.is_part
        ),
        Predicate(
            "labelled",
            2,
            labelled,
            doc="The log names a task for this action, done to a thing.",
            phases=frozenset({"run"}),
            complete=True,
            possible=lambda timeline: bool(timeline.labelled),
            classes=(0,),
        ),
        *motion_predicates.all_predicates(),
        *place_predicates.all_predicates(),
        *attitudes.all_predicates(),
    )


def _of_states() -> tuple[Predicate, ...]:
    """Return the predicates on relations that change only where a state of the recording begins or ends, such
    as ``grasps``."""
    known = partial(Predicate, steady=True, complete=True)
    return (
        known("grasps", 2, grasps, doc="Gripper holds thing.", fluent=fluents.GRASPS, unknown=unknowns.no_grasps),
        known("supports", 2, supports, doc="Supporter carries supportee.", fluent=fluents.SUPPORTS, unknown=unknowns.no_supports),
        known(
            "touches", 2, touches, doc="Two things, or their parts, are in contact; symmetric.", cost=2,
            fluent=fluents.TOUCHES, unknown=unknowns.no_contacts,
        ),
        known(
            "collides", 2, collides, doc="A member of the kinematic chain touches what is not.", cost=2,
            fluent=fluents.COLLIDES, unknown=unknowns.no_contacts,
        ),
        known(
            "chain", 1, chain, doc="The effector, its parts, what it grasps, and the parts of that.",
            static=fluents.in_chain,
        ),
        known(
            "contains",
            2,
            contains,
            doc="Container holds content.",
            possible=lambda timeline: bool(timeline.boundaries("soma:ContainmentState")),
            fluent=fluents.CONTAINS,
            unknown=unknowns.no_contents,
        ),
        known(
            "on_container", 1, on_container, cost=3, doc="A thing touches or rests on a container that is not its own."
        ),
        Predicate(
            "constrained_dof",
            2,
            constrained_dof,
            value=True,
            steady=True,
            cost=3,
            doc="Degrees of freedom that a thing's contact takes from another.",
            static=fluents.constrained_dof,
        ),
    )


@hookimpl
def predicates() -> Iterable[Predicate]:
    """Declare the shipped predicates."""
    return all_predicates()


def effector(phase: Phase, _name: str | None) -> Iterator[Row]:
    """Evaluate effector(Gripper): the episode's effector; without one, every prehensile effector that is no part of another."""
    if phase.episode.effector is not None:
        yield (phase.episode.effector,)
        return
    for name in phase.timeline.entities_of("soma:PrehensileEffector"):
        if phase.timeline.entities[name].part_of is None:
            yield (name,)


def grasps(phase: Phase, _gripper: str | None, _thing: str | None) -> Iterator[Row]:
    """Evaluate grasps(Gripper, Thing), from cram:GraspState."""
    return _filled(phase, "cram:GraspState", "gripper", "object")


def supports(phase: Phase, _supporter: str | None, _supportee: str | None) -> Iterator[Row]:
    """Evaluate supports(Supporter, Supportee), from soma:SupportState.

    What supports or carries a part does so for the whole.
    """
    for supporter, supportee in _filled(phase, "soma:SupportState", "supporter", "supportee"):
        yield from _lifted(phase, supporter, supportee)


def contains(phase: Phase, _container: str | None, _content: str | None) -> Iterator[Row]:
    """Evaluate contains(Container, Content), from soma:ContainmentState."""
    return _filled(phase, "soma:ContainmentState", "container", "content")


def _filled(phase: Phase, type_: str, one: str, other: str) -> Iterator[tuple[str, str]]:
    """Generate the pairs of entities in two roles of the states of a type, for each state in which both roles are filled."""
    for state in phase.states(type_):
        if one in state.roles and other in state.roles:
            yield state.roles[one], state.roles[other]


def touches(phase: Phase, _a: str | None, _b: str | None) -> Iterable[Row]:
    """Evaluate touches(A, B), from soma:ContactState, in both orders; a part's contact counts as one of
    its whole."""
    if "touches" not in phase.situation:
        phase.situation["touches"] = tuple(_contact_rows(phase, phase.states("soma:ContactState")))
    return phase.situation["touches"]  # type: ignore[no-any-return]


def collides(phase: Phase, _a: str | None, _b: str | None) -> Iterator[Row]:
    """Evaluate collides(A, B): A belongs to the kinematic chain, B does not, and they touch.

    While an action lasts any contact counts, however short; the published rules saw only those
    that span the action.
    """
    members = {row[0] for row in chain(phase, None)}
    anytime = phase.overlapping("soma:ContactState")
    spanning = len(anytime) == len(phase.states("soma:ContactState"))
    for a, b in touches(phase, None, None) if spanning else _contact_rows(phase, anytime):
        if a in members and b not in members:
            yield a, b


def chain(phase: Phase, _name: str | None) -> Iterable[Row]:
    """Evaluate chain(X): the kinematic chain: effector, its payload, and the parts of both."""
    if "chain" not in phase.situation:
        heads = {row[0] for row in effector(phase, None)}
        heads |= {thing for gripper, thing in grasps(phase, None, None) if gripper in heads}
        wholes = phase.timeline.wholes
        phase.situation["chain"] = tuple((n,) for n in wholes if any(w in heads for w in wholes[n]))
    return phase.situation["chain"]  # type: ignore[no-any-return]


def isa(phase: Phase, thing: str | None, class_: str | None) -> Iterator[Row]:
    """Evaluate isa(Thing, Class), e.g. isa(Thing, vrps:Peg)."""
    if class_ is None:
        return
    if thing is None:
        yield from ((name, class_) for name in phase.timeline.entities_of(class_))
    elif phase.taxonomy.any_is_a(phase.timeline.types(thing), class_):
        yield thing, class_


def has(phase: Phase, thing: str | None, class_: str | None) -> Iterator[Row]:
    """Evaluate has(Thing, Class), e.g. soma:Surface: Thing is of the class, has a part of that class, or its own class
    says so (soma:hasFeature)."""
    if class_ is None:
        return
    owners = {w for name in phase.timeline.entities_of(class_) for w in phase.timeline.wholes[name]}
    for name in phase.timeline.entities if thing is None else [thing]:
        types = phase.timeline.types(name)
        if name in owners or any(phase.taxonomy.offers(t, "soma:hasFeature", class_) for t in types):
            yield name, class_


def part(phase: Phase, _thing: str | None, _part: str | None) -> Iterator[Row]:
    """Evaluate part(Thing, Part): Part belongs to Thing, directly or through other parts."""
    for name, wholes in phase.timeline.wholes.items():
        yield from ((whole, name) for whole in wholes[1:])


def constrained_dof(phase: Phase, thing: str | None, other: str | None) -> Iterator[Row]:
    """Evaluate constrained_dof(Thing, Other): the most degrees of freedom that a part of Thing takes away.

    The parts are those in contact with Other, or supporting it; a peg in a hole takes four, a table top one.
    """
    if thing is None or other is None:
        return
    pairs = [*touches(phase, None, None), *supports(phase, None, None)]
    through = {str(a) for a, b in pairs if b == other and thing in phase.timeline.wholes.get(str(a), ())}
    yield thing, other, max(_dof(phase, name) for name in through | {thing})


def on_container(phase: Phase, thing: str | None) -> Iterator[Row]:
    """Evaluate on_container(Thing): it touches, or is supported by, a soma:DesignedContainer or a part of one."""
    containers = set(phase.timeline.entities_of("soma:DesignedContainer"))
    for a, b in [*touches(phase, None, None), *supports(phase, None, None)]:
        if thing in (None, b) and a in containers and a != b:
            yield (b,)


def labelled(phase: Phase, _task: str | None, _thing: str | None) -> Iterator[Row]:
    """Evaluate labelled(Task, Thing): the recording's event log names the task and the thing for the action
    that spans the phase."""
    for event in phase.timeline.labelled:
        if event.start == phase.start and event.end == phase.end and "object" in event.roles:
            type_ = phase.taxonomy.resolve(event.type) or event.type
            yield from ((above, event.roles["object"]) for above in phase.taxonomy.ancestors(type_))


def _dof(phase: Phase, name: str) -> float:
    entity = phase.timeline.entities.get(name)
    if entity is not None and "constrained_dof" in entity.properties:
        return entity.properties["constrained_dof"]
    said = [f for t in phase.timeline.types(name) for f in phase.taxonomy.fillers(t, "cram:constrainedDof")]
    return max((float(f) for f in said), default=fluents.DEFAULT_DOF)


def _contact_rows(phase: Phase, states: Iterable[object]) -> Iterator[Row]:
    for state in states:
        roles = state.roles  # type: ignore[attr-defined]
        if "a" in roles and "b" in roles:
            for a, b in _lifted(phase, roles["a"], roles["b"]):
                yield a, b
                yield b, a


def _lifted(phase: Phase, a: str, b: str) -> Iterable[tuple[str, str]]:
    """Pairs of entities to which a relation of two entities extends: each entity or a whole that it is part
    of, but never a thing with its own part."""
    known = phase.timeline.memo
    key = ("lifted", a, b)
    if key not in known:
        wholes = phase.timeline.wholes
        above_a, above_b = wholes.get(a, (a,)), wholes.get(b, (b,))
        known[key] = [(x, y) for x in above_a for y in above_b if x not in above_b and y not in above_a]
    return known[key]  # type: ignore[no-any-return]
