# ruff: noqa: E501 (a table)
"""SECURITY.md is true: which commands listen where, and that no module reads pickles or runs text but those that are named."""

from __future__ import annotations

import ast
import io
import re
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT
from helpers.audited import audited

from cramlite import Engine
from cramlite.cli import view
from cramlite.cli.main import main
from cramlite.cli.serving import mcp, serve
from cramlite.plugin import UserError
from cramlite_plugins.ur_controller.network import serve as serve_controller

PAGE = (ROOT / "SECURITY.md").read_text(encoding="utf-8")
SOURCES = [*(ROOT / "cramlite").rglob("*.py"), *(ROOT / "plugins").rglob("*.py"), *(ROOT / "experiments").rglob("*.py")]
DANGEROUS = {
    "pickle": {"cramlite/engine/proof/executor.py", "experiments/libero/obstacles.py"}, "marshal": set(), "shelve": set(), "dill": set(), "cloudpickle": set(), "joblib": set(), "torch": set(),
    "tarfile": set(), "zipfile": {"cramlite/base/guarded_files.py", "experiments/libero/obstacles.py"}, "eval": set(), "exec": {"plugins/cramlite_plugins/ur_controller/urscript/interpreter.py"},
    "compile": {"plugins/cramlite_plugins/ur_controller/urscript/python_subset.py"}, "load": set(), "unsafe_load": set(), "full_load": set(), "extractall": set(),
    "unpack_archive": set(), "urlopen": set(), "allow_pickle": set(), "shell": set(),
}  # fmt: skip
"""Modules, functions and arguments by which a text becomes code, a file, or a request -> the only modules that use them."""
OWNERS = {"load": ("yaml", "np", "numpy", "marshal", "joblib", "torch", "dill"), "compile": ("",), "eval": ("",), "exec": ("",)}
"""Of functions with a common name: of which module they are meant, "" for Python's own."""


def dangerous(tree: ast.AST) -> Iterator[str]:
    """The dangerous names that a source uses."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (a.name.partition(".")[0] for a in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield (node.module or "").partition(".")[0]
        elif isinstance(node, ast.Call):
            owner, name = (ast.unparse(node.func.value), node.func.attr) if isinstance(node.func, ast.Attribute) else ("", ast.unparse(node.func))
            if name not in OWNERS or owner in OWNERS[name]:
                yield name
            yield from (k.arg for k in node.keywords if k.arg in ("allow_pickle", "shell") and ast.unparse(k.value) != "False")


def test_text_becomes_code_in_the_named_modules_only() -> None:
    found: dict[str, set[str]] = {name: set() for name in DANGEROUS}
    words = re.compile(rf"\b(?:{'|'.join(DANGEROUS)})\b")
    for path in SOURCES:
        text = path.read_text(encoding="utf-8")
        if not words.search(text):
            continue
        for name in set(dangerous(ast.parse(text))) & set(DANGEROUS):
            found[name].add(path.relative_to(ROOT).as_posix())
    assert found == DANGEROUS


@pytest.mark.parametrize("source", ["import pickle", "np.load(f, allow_pickle=True)", "yaml.load(t)", "eval(t)", "from torch import load"])
def test_a_use_would_be_noticed(source: str) -> None:
    assert set(dangerous(ast.parse(source))) & set(DANGEROUS)


def listening(command: str) -> str:
    """What the page says of where a command listens."""
    row = next(line for line in PAGE.splitlines() if line.startswith(f"| `{command}`"))
    return row.split("|")[2].strip()


def test_serve_opens_no_socket() -> None:
    assert listening("serve").startswith("nothing")
    out = io.StringIO()
    with audited() as heard:
        serve.Service(Engine(), io.StringIO('{"id": 1, "method": "tasks"}\n'), out).run()
    assert '"result"' in out.getvalue()
    assert not [event for event, _ in heard if event in ("socket.bind", "socket.connect", "subprocess.Popen")]


def test_mcp_over_http_is_bound_to_loopback() -> None:
    with mcp._listen(0) as bound:
        assert bound.getsockname()[0] == "127.0.0.1"
    assert listening("mcp --http PORT") == "`127.0.0.1` always"
    assert listening("mcp").startswith("nothing")


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.1", "example.org", ""])
def test_the_controller_refuses_other_addresses(host: str) -> None:
    with pytest.raises(UserError, match="loopback addresses only"):
        serve_controller(None, host, seconds=1, idle=1, ready=print)  # type: ignore[arg-type]


def test_the_viewer_asks_for_the_address_that_it_was_given() -> None:
    with audited() as heard:
        port = view.free_port("127.0.0.1", 50_000)
    assert [event for event, _ in heard].count("socket.bind") >= 1
    with socket.create_server(("127.0.0.1", port)) as bound:
        assert bound.getsockname()[0] == "127.0.0.1"


@pytest.mark.parametrize("module", [view, mcp])
def test_addresses_are_loopback_unless_told(module: object) -> None:
    """What the parsers of commands that listen take by default."""
    hosts = re.findall(r'"--host", default="([^"]+)"', Path(str(module.__file__)).read_text(encoding="utf-8"))  # type: ignore[attr-defined]
    assert set(hosts) <= {"127.0.0.1"}


def test_commands_that_the_page_names_are_there(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    said = capsys.readouterr().out
    named = set(re.findall(r"^\| `([a-z]+)[ `]", PAGE, re.MULTILINE))
    assert {"serve", "mcp", "controller", "view", "experiment", "judge"} <= named
    assert all(re.search(rf"^    {command}\b", said, re.MULTILINE) for command in named)


@pytest.mark.parametrize("page", ["README.md", "docs/index.md", "docs/reference/cli.md", "docs/how-to/task_plugin.md"])
def test_strangers_find_the_page(page: str) -> None:
    assert "SECURITY.md" in (ROOT / page).read_text(encoding="utf-8")
