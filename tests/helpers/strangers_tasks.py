"""Task plugins as a stranger writes them: ``cramlite new task NAME``, with the conditions of its rule replaced."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

from cramlite.plugin.entry_points import module_from
from cramlite.testing.skeleton import write_skeleton

HOLDING = ("grasps(Gripper, Patient)",)
EMPTY = ("not grasps(Gripper, _)",)
PLACE = ("thing(Relatum)", "has(Relatum, soma:Surface)")
RULES = {
    "polishing": None,  # as written
    "dipping": (HOLDING, (*HOLDING, "thing(Relatum)", "in_or_above(Patient, Relatum)", "not supports(_, Patient)")),
    "shelving": (EMPTY, (*PLACE, "supports(Relatum, Patient)", "in_or_above(Patient, Relatum)")),
    "emptying": (HOLDING, ("not grasps(Gripper, _)", "not touches(Gripper, _)", "not supports(_, Patient)", "not contains(Patient, _)",
                           "thing(Relatum)", "in_or_above(Patient, Relatum)", "joint_open(Patient)")),
    "tossing": (HOLDING, ("not grasps(Gripper, Patient)", "not touches(Gripper, _)", "thing(Relatum)", "in_or_above(Patient, Relatum)")),
}  # fmt: skip
"""Name of a task -> conditions before and after it. All but the last change more than a goal asks for."""
NUISANCES = ("polishing", "dipping", "shelving", "emptying")


def stranger(name: str, folder: Path) -> Path:
    """Write the module of a task plugin, and return its path."""
    package = write_skeleton("task", name, folder / name)[0]
    module = package / f"cramlite_{name}" / "__init__.py"
    if (rule := RULES[name]) is not None:
        before, after = ("\n".join(f"  - {c}" for c in conditions) for conditions in rule)
        roles = "roles:\n  Patient: soma:Patient\n  Relatum: soma:RelatumRole\n"
        text = f"task: cram:{name.title()}\n{roles}source: nobody\npre:\n  - effector(Gripper)\n{before}\npost:\n{after}\n"
        (module.parent / f"{name}.yaml").write_text(text + 'explain: "{Patient} is treated"\n')
    return _named(module, name)


def _named(module: Path, name: str) -> Path:
    """Rename a plugin's module to the task's name, since plugins of files are named after their files."""
    return module.rename(module.with_name(f"{name}.py"))


def imported(file: Path) -> ModuleType:
    """Import the module of a plugin, as a test by its author does."""
    return module_from(file)
