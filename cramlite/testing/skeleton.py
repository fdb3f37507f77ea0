"""Skeleton of a new plugin as a package: complete, installable and tested, to be changed by its author."""

from __future__ import annotations

import importlib.metadata
import keyword
import re
from collections.abc import Mapping
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from ..base.errors import UserError
from ..base.run_directory import require_vacant
from ..ontology.foundation import TASK
from ..plugin.expert import OBJECTS, SEGMENT, SEGMENTS, VIEW
from ..version import VERSION

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge

KINDS = ("backend", "expert", "predicate", "robot", "task", "validator")
"""Kinds of plugin that ``cramlite new`` writes; each has a folder of templates in ``skeletons/``."""

LONGEST = 40
"""Characters of a name: it becomes part of file, module and class names."""

EXPERT_WORDS = (VIEW, SEGMENT, SEGMENTS, OBJECTS)
"""Names that have a meaning for the engine, so that no expert may have them."""

_PLACES = {
    "pyproject.toml": "pyproject.toml",
    "README.md": "README.md",
    "module.py": "{package}/__init__.py",
    "rule.yaml": "{package}/{name}.yaml",
    "test.py": "tests/test_{name}.py",
    "scenario.yaml": "tests/try_{name}.yaml",
}
"""Name of a template -> path of the file that is written from the template."""


def write_skeleton(kind: str, name: str, out: Path | None = None) -> tuple[Path, ...]:
    """Write a package for a new plugin.

    Args:
        kind: one of ``KINDS``.
        name: of the plugin, in small letters, e.g. "wiping" or "no_spill".
        out: the package's folder; ``cramlite-NAME`` in the current one if nothing is said.

    Returns:
        the files, the folder first.

    Raises:
        UserError: the name cannot be used, or something that is installed has it already, or the folder is not empty.
    """
    return fill(kind, kind, name, out, {})


def fill(templates: str, kind: str, name: str, out: Path | None, further: Mapping[str, str]) -> tuple[Path, ...]:
    """Write a package from a folder of templates, with further texts for their placeholders.

    It raises the same errors as ``write_skeleton``.
    """
    folder = vacant_folder(kind, name, out)
    words = {**_words(kind, name), **further}
    files = []
    for template in sorted(p for part in ("common", templates) for p in _templates(part)):
        path = folder / _PLACES[template.stem].format(**words)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(Template(template.read_text(encoding="utf-8")).substitute(words), encoding="utf-8")
        files.append(path)
    return folder, *files


def vacant_folder(kind: str, name: str, out: Path | None) -> Path:
    """Return the folder for a new package, checked to be free; nothing is written yet.

    Raises:
        UserError: as ``write_skeleton``.
    """
    why = _taken(kind, _checked(name))
    if why:
        raise UserError(f"The {kind} cannot be called '{name}': {why}. Choose another name; nothing was written.")
    folder = out or Path(f"cramlite-{name.replace('_', '-')}")
    require_vacant(folder, "written")
    return folder


def _templates(part: str) -> list[Path]:
    return sorted((Path(__file__).parent / "skeletons" / part).glob("*.txt"))


def _words(kind: str, name: str) -> Mapping[str, str]:
    """Return the texts for the placeholders of the templates."""
    major, minor = VERSION.split(".")[:2]
    return {
        "kind": kind, "name": name, "camel": camel(name), "package": f"cramlite_{name}",
        "distribution": f"cramlite-{name.replace('_', '-')}", "minor": f"{major}.{minor}", "next": f"{major}.{int(minor) + 1}",
    }  # fmt: skip


def camel(name: str) -> str:
    """Convert a name to camel case: "no_spill" to "NoSpill"."""
    return "".join(part[:1].upper() + part[1:] for part in name.split("_"))


def _checked(name: str) -> str:
    """Return a name, checked to be valid for modules, entry points and classes."""
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name) or len(name) > LONGEST:
        small = re.sub(r"[^a-z0-9]+", "_", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()).strip("_0123456789")
        hint = f" '{small[:LONGEST]}' would do." if small else ""
        raise UserError(
            f"'{name}' cannot be the name of a plugin: write small letters, digits and single underscores, a letter first, "
            f"{LONGEST} characters at most, since module, entry point and class are named after it.{hint}"
        )
    if keyword.iskeyword(name) or keyword.issoftkeyword(name):
        raise UserError(f"'{name}' is a word of Python and cannot name a plugin; '{name}_task', say, can.")
    for point in importlib.metadata.entry_points(group="cramlite"):
        if point.name == name:
            owner = point.dist.name if point.dist else point.value
            raise UserError(
                f"There is a plugin '{name}' already, in '{owner}' ({point.value}); two of one name cannot be loaded. "
                "'cramlite plugins' lists the names that are taken; choose another."
            )
    return name


def _taken(kind: str, name: str) -> str:
    """Return why a new plugin cannot have a name, such as that another plugin has it; "" if it can."""
    from ..plugin.catalogue import Knowledge
    from ..plugin.registry import Registry
    from ..plugin.validation import NAMED_BY

    if name == "plugins":
        return "its package would be 'cramlite_plugins', which is the shipped plugins' own"
    if re.search(rf"\b{camel(name)}\b", "".join(t.read_text(encoding="utf-8") for t in _templates(kind))):
        return f"its class would be '{camel(name)}', a name that the module needs for something else"
    registry = Registry()
    if kind == "task":
        return _taken_task(camel(name), Knowledge(registry))
    hook = f"{kind}s"
    owner = next((p for p, item in registry.collect(hook) if getattr(item, NAMED_BY[hook][0]) == name), "")
    if kind == "expert" and name in EXPERT_WORDS:
        return "an expert makes a value of its own name, and that one is the engine's"
    return f"the plugin '{owner}' declares the {kind} '{name}', and names are unique" if owner else ""


def _taken_task(local: str, knowledge: Knowledge) -> str:
    """Return why there cannot be a task "cram:LOCAL": another task, rule or class has the name; "" if it is
    free."""
    for task in knowledge.tasks.values():
        if local in (task.task.split(":")[-1], *task.aliases):
            return f"'{local}' is taken: it names the task '{task.task}' of the plugin '{knowledge.task_owners[task.task]}'"
    taxonomy, own = knowledge.taxonomy, f"cram:{local}"
    rule = next((r for r in knowledge.rules if r.task == own), None)
    if rule is not None:
        return f"'{own}' has a rule already ({rule.path.name}), by which it is recognised in demonstrations"
    same = [c for c in taxonomy.classes if c.split(":")[-1] == local]
    other = next((c for c in same if c == own or not taxonomy.is_a(c, TASK)), "")
    return f"there is a class '{other}' already" if other else ""


def skeleton_text(kind: str, files: tuple[Path, ...]) -> str:
    """Return text with the files of a new package and the next step."""
    folder, *written = files
    article = "an" if kind[0] in "aeiou" else "a"
    lines = [f"Wrote {article} {kind} plugin to '{folder}':", *(f"  {path.relative_to(folder)}" for path in written)]
    return "\n".join([*lines, "It works as it is; change it step by step:",
                      f"  cd {folder} && pip install -e '.[test]' && cramlite plugins && pytest"])  # fmt: skip
