"""Package of a learned task, ready to install: class, rule, known decomposition into steps, tests, and a page with
the evidence."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib.resources import files
from pathlib import Path

from ..base.html_template import html_template, write_html
from ..testing.skeleton import fill
from .motion_text import force_said, motion_words, said
from .procedure import plan_text
from .proposal import Proposal

PAGE = "learned.html"


def write_package(proposal: Proposal, name: str, out: Path | None = None) -> tuple[Path, ...]:
    """Write a learned task as a package.

    Args:
        name: of the plugin, in small letters; the task is called after it.
        out: folder; ``cramlite-NAME`` in the current one if nothing is said.

    Returns:
        the files, the folder first.

    Raises:
        UserError: the name is taken or cannot be used, or the folder is not empty.
    """
    folder, *written = fill("learned", "task", name, out, _words(proposal, name))
    page = folder / PAGE
    write_html(page, page_text(proposal))
    return (folder, *written, page)


def page_text(proposal: Proposal) -> str:
    """Return the page about a learned task as HTML: its rule, the evidence for each condition, dropped
    conditions, open questions."""
    return html_template((files(__package__) / "learned.html.j2").read_text(encoding="utf-8")).render(
        found=proposal, plan=plan_text(proposal.procedure) if proposal.procedure and proposal.steps else "",
        motion=said(proposal), force=force_said(proposal),
    )


def _words(proposal: Proposal, name: str) -> Mapping[str, str]:
    spoken = name.replace("_", " ")
    steps = proposal.steps
    classes = sorted({c for s in steps for _, c in s.fillers if c not in proposal.roles})
    moved = motion_words(proposal, name)
    model, plugin = _imports(proposal, bool(classes))
    count = sum(len(texts) for texts in proposal.rule.values())
    said = [f"{phase}:\n" + "\n".join(f"  - {text}" for text in texts) for phase, texts in proposal.rule.items() if texts]
    examples = len(proposal.learned.examples)
    return {
        "task": proposal.task, "above": proposal.above, "summary": f"{spoken}, as it was shown", "count": str(count),
        "roles": "roles:" + "".join(f"\n  {r}: {c}" for r, c in proposal.roles.items()) if proposal.roles else "roles: {}",
        "role_list": "".join(f'Role("{r}"), ' for r in proposal.roles).rstrip() if proposal.roles else "",
        "conditions": "\n".join(said), "examples": f"{examples} demonstration{'s' if examples > 1 else ''}",
        "explain": f"{spoken}: {' and '.join(f'{{{r}}}' for r in proposal.roles)}" if proposal.roles else spoken,
        "shown_roles": "".join(f", {r}: {thing_name(r)}" for r in proposal.roles), "shown_before": "".join(_before(proposal)),
        "shown_things": "".join(_things(proposal)),
        "model_names": model, "plugin_names": plugin, "decompose": _decompose(proposal, classes),
        "constants": "", "parameters": "", "hooks": "", **moved,
    }  # fmt: skip


def _imports(proposal: Proposal, classes: bool) -> tuple[str, str]:
    """Return the names that the task's module imports from ``cramlite.model`` and from
    ``cramlite.plugin``."""
    if proposal.moving:
        model = "Action, Anchor, Belief, Location, Motion, ShownPath" + ("" if proposal.moving[0].path.anchor.own else ", Stage")
        return model, "Decomposition, Parameter, Predicate, Role, TaskType, Unresolvable, hookimpl, path_predicate"
    if proposal.turning:
        model = "Action, Belief, ExpectedGrip, Fingers, Location, Motion, Stage"
        return model, "Decomposition, Parameter, Predicate, Role, TaskType, hookimpl, turn_predicate"
    model = "Action, Belief" + (", Motion" if proposal.rest and proposal.done else "") + (", Object" if classes else "")
    plugin = "Decomposition, " + ("Parameter, Predicate, " if proposal.rest else "") + "Role, TaskType, "
    plugin += ("" if proposal.done else "Unresolvable, ") + "hookimpl" + (", rest_predicate" if proposal.rest else "")
    return model, plugin


def thing_name(role: str) -> str:
    """Return a name for the thing that fills a role in the scenario of a learned task, such as "some_patient"."""
    return f"some_{role.lower()}"


def _before(proposal: Proposal) -> Iterator[str]:
    """Yield lines of a scenario with the known tasks that come before the learned task in all examples.

    These bring its payload into the hand, for example.

    Things that fill no role of the learned task are replaced by the floor, on which all things of that
    scenario stand.
    """
    shown = []
    for one, fillers in zip(proposal.learned.examples, proposal.fillers, strict=True):
        names = dict(zip(fillers, map(thing_name, proposal.roles), strict=True))
        before = [k for k in one.around if k.task and k.span.start < one.span.start and set(k.roles.values()) & set(fillers)]
        shown.append([(k.task, {r: names.get(n, "floor") for r, n in k.roles.items() if n != k.span.effector}) for k in before])
    if all(found == shown[0] for found in shown):
        yield from (f"  - {{task: {task}, {', '.join(f'{r}: {n}' for r, n in roles.items())}}}\n" for task, roles in shown[0])


def _things(proposal: Proposal) -> Iterator[str]:
    """Yield a scenario line for the thing in each role: a lid if the thing was turned, a block if it was moved, else a table."""
    span, mover = proposal.learned.examples[0].span, proposal.moving[1] if proposal.moving else ""
    for k, role in enumerate(proposal.roles):
        y, shown = -0.35 + 0.25 * k, proposal.fillers[0][k]
        turned = proposal.turning is not None and proposal.turning[1] == role
        shape = f"model: screw_lid, at: {{position: [0.5, {y:g}, 0.2]}}, with: {{turned: 2.2}}" if turned else (
            f"model: block, at: {{position: [0.5, {y:g}, 51 mm]}}, with: {{size: [50 mm, 50 mm, 100 mm]}}"
            if role == mover or span.elsewhere(shown)
            else f"model: table, at: {{position: [0.45, {y:g}, 0.15]}}, with: {{size: [0.22 m, 0.22 m, 20 mm]}}"
        )
        yield f"  - {{name: {thing_name(role)}, {shape}}} # {next(iter(span.timeline.types(shown)), shown)} was shown\n"


def _decompose(proposal: Proposal, classes: list[str]) -> str:
    if not proposal.done:
        return (
            f'        raise Unresolvable("how {proposal.task} is done was not learned: no sequence of known tasks explains what "\n'
            '                           "was shown; write it here")'
        )
    lines = [f'        some_{k} = Object("some_{k}", ("{class_}",))' for k, class_ in enumerate(classes)]
    lines.append("        steps = (")
    for k, step in enumerate(proposal.steps, 1):
        fillers = {r: f'action.roles["{c}"]' if c in proposal.roles else f"some_{classes.index(c)}" for r, c in step.fillers}
        roles = ", ".join(f'"{r}": {f}' for r, f in fillers.items())
        lines.append(f'            Action(action.inside("{k}_{step.task.split(":")[-1]}"), "{step.task}", {{{roles}}}),')
    if proposal.rest:
        rest = 'Motion(action.inside("rest"), "hold", None, {"duration_s": self.parameter(action, "rest_s")}, reason="as it was shown")'
        lines.append(f"            {rest},")
    return "\n".join([*lines, "        )", '        yield Decomposition(steps, "as it was shown")'])
