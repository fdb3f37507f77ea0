"""Trials as tasks of Dask: the same to the bit as in one process, and nothing lost or counted twice whoever dies."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("distributed", reason="the extra cramlite[distributed] is not installed")

from helpers.quick_experiment import order, quick_experiment, solved_experiment, told

from cramlite import UserError
from cramlite.base.json_text import as_json
from cramlite.cli.main import main
from cramlite.experiment.cluster import check_executor, connected
from cramlite.experiment.cluster_tasks import trial_task
from cramlite.experiment.demonstrations.report import to_json
from cramlite.experiment.demonstrations.results import DemonstrationResult
from cramlite.experiment.demonstrations.tables import tables
from cramlite.experiment.demonstrations.trials import Demonstrations
from cramlite.experiment.run import run_experiment
from cramlite.experiment.store import Store
from cramlite.model import replace


@pytest.mark.heavy
def test_tables_are_those_of_one_process_to_the_bit(tmp_path: Path) -> None:
    experiment, found = solved_experiment(tmp_path / "solved"), {}
    for executor in ("local", "dask"):
        results = list(run_experiment(order(experiment, tmp_path / executor, 2, executor=executor), lambda _: None).values())
        data = json.loads(as_json(to_json(tables(results, None), results, {})))
        spent = [data.pop("seconds"), *(c.pop("seconds") for d in data["demonstrations"] for c in (d, *d["results"]))]
        spent += [row.pop("planning") for row in data["rows"]]
        texts = {p.name: p.read_bytes() for p in (tmp_path / executor / "results").rglob("*.script")}
        found[executor] = json.dumps(data), texts
        assert spent[0]["twins"] > 0
    assert found["local"] == found["dask"]
    assert results[0].solved and results[0].results[0].attempts[0].confidence == 1 and found["dask"][1]


DIES = """
import os
from pathlib import Path
from cramlite.plugin import hookimpl

@hookimpl(tryfirst=True)
def read_episode(path):
    mark = Path({mark!r})
    if path.name == "O3-01" or (path.name == "O2-01" and not mark.exists()):
        mark.write_text("")
        os._exit(9)
"""


@pytest.mark.heavy
def test_a_cluster_finds_the_same_and_a_lost_worker_is_replaced(tmp_path: Path) -> None:
    experiment, plugin, said = quick_experiment(tmp_path / "quick"), tmp_path / "dies.py", []
    plugin.write_text(DIES.format(mark=str(tmp_path / "mark")))
    run_experiment(order(experiment, tmp_path / "one"), lambda _: None)
    found = run_experiment(order(experiment, tmp_path / "many", 2, plugin, executor="dask"), said.append)
    one, many = told(tmp_path / "one"), told(tmp_path / "many")
    assert many["results/O3-01/result.json"]["reason"] == "worker: the process died 4 times (out of memory, or killed)"
    same = [name for name in one if "O3-01" not in name]
    assert len(same) == 4 and {n: one[n] for n in same} == {n: many[n] for n in same}
    assert list(found) == [r.name for r in found.values()] == ["O1-01", "O2-01", "O3-01"]
    assert sum("O2-01" in line for line in said) == 1 and "[3/3]" in said[-1]
    for name in ("O1-01", "O2-01"):
        texts = [p.relative_to(tmp_path / "one") for p in (tmp_path / "one" / "demonstrations" / name).rglob("*.bson")]
        assert texts and all((tmp_path / "one" / t).read_bytes() == (tmp_path / "many" / t).read_bytes() for t in texts)
    assert not list((tmp_path / "many").rglob("begun")) and not list((tmp_path / "many").glob(".arriving*"))


WAITS = """
import time
from pathlib import Path
from cramlite.plugin import hookimpl

@hookimpl(tryfirst=True)
def read_episode(path):
    while path.name == "O3-01" and Path({mark!r}).exists():
        time.sleep(0.1)
"""


@contextmanager
def dask_process(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    started = subprocess.Popen([sys.executable, "-m", *words], start_new_session=True, **quiet)
    try:
        yield started
    finally:
        os.killpg(started.pid, signal.SIGKILL)
        started.wait()


@contextmanager
def cluster(port: int, folder: Path) -> Iterator[None]:
    """A scheduler at a port, and one worker."""
    place = f"tcp://127.0.0.1:{port}"
    scheduler = ("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard")
    worker = ("distributed.cli.dask_worker", place, "--nworkers", "1", "--nthreads", "1", "--no-dashboard")
    worker += ("--local-directory", str(folder))
    with dask_process(*scheduler), dask_process(*worker):
        yield


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


def wait_for(there: object, seconds: float = 90) -> None:
    end = time.monotonic() + seconds
    while not there():  # type: ignore[operator]
        assert time.monotonic() < end, "it never came"
        time.sleep(0.1)


@pytest.mark.heavy
def test_a_killed_client_and_a_restarted_scheduler_lose_nothing(tmp_path: Path) -> None:
    experiment, out, mark, plugin = quick_experiment(tmp_path / "quick"), tmp_path / "out", tmp_path / "mark", tmp_path / "waits.py"
    plugin.write_text(WAITS.format(mark=str(mark)))
    mark.write_text("the last demonstration is not read while this is here")
    port, said = free_port(), []
    where, first = f"dask://127.0.0.1:{port}", out / "results" / "O1-01" / "result.json"
    with cluster(port, tmp_path):
        words = [sys.executable, "-m", "cramlite", "experiment", experiment, "--out", out, "--plugin", plugin, "--executor", where]
        client = subprocess.Popen([*words, "--no-pictures"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_for(first.exists)
        client.kill()
        client.wait()
        before = first.stat().st_mtime_ns
        again = threading.Thread(target=run_experiment, args=(order(experiment, out, 1, plugin, executor=where), said.append))
        again.start()
        time.sleep(3)  # it has handed out what is left
    wait_for(lambda: any("the scheduler was lost" in line for line in said))
    mark.unlink()
    with cluster(port, tmp_path):
        again.join(timeout=120)
    assert not again.is_alive() and first.stat().st_mtime_ns == before
    assert not any("O1-01" in line for line in said)
    run_experiment(order(experiment, tmp_path / "one", 1, plugin), lambda _: None)
    assert told(out) == told(tmp_path / "one") and len(told(out)) == 6


def test_files_that_arrive_count_when_the_result_does(tmp_path: Path) -> None:
    (tmp_path / "results").mkdir()
    store = Store(tmp_path, "results", DemonstrationResult)
    files = {"demonstrations/O1-01/tf/a.bson": b"1", "results/O1-01/1.script": b"text", "results/O1-01/result.json": b"{}"}
    with pytest.raises(KeyError):  # one whose result is missing
        store.receive("O1-01", {n: t for n, t in files.items() if not n.endswith("result.json")})
    assert not (tmp_path / "results/O1-01/result.json").exists()
    for _ in range(2):  # also where it arrives again
        store.receive("O1-01", files | {"elsewhere": b"no"})
    assert {p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*") if p.is_file()} == set(files)


def test_a_worker_with_other_files_is_refused(tmp_path: Path) -> None:
    asked = order(quick_experiment(tmp_path / "quick"), tmp_path / "out")
    name, key = asked.trials.names[0], asked.trials.key()
    with pytest.raises(UserError, match=r"would give other results than this machine \(different: code\).*None of its results was counted"):
        trial_task(asked, name, key | {"code": "another"})
    elsewhere = replace(asked, trials=Demonstrations(tmp_path / "nowhere" / "experiment.yaml"))
    with pytest.raises(UserError, match="cannot use the experiment"):
        trial_task(elsewhere, name, key)


@pytest.mark.parametrize("executor", ["dusk", "dask:", "dask://", "dask://host", "dask://host:port", "tcp://host:1", "dask://a b:1"])
def test_executors_that_there_are_not(executor: str, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["experiment", "fetch_from_hanger", "--executor", executor, "--out", str(tmp_path / "out")]) == 2
    assert "'dask://HOST:PORT', the address of a cluster's scheduler" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_scheduler_that_is_not_there() -> None:
    assert check_executor("dask://127.0.0.1:8786")
    with pytest.raises(UserError, match=r"no Dask scheduler at 'dask://127.0.0.1:\d+' .*dask scheduler"), connected(
        f"dask://127.0.0.1:{free_port()}", 1, patience=1
    ):
        pass
    with pytest.raises(UserError, match=r"no Dask scheduler at 'dask://no.such.host.invalid:8786'"), connected(
        "dask://no.such.host.invalid:8786", 1, patience=1
    ):
        pass


def test_nothing_of_it_is_loaded_before_it_is_asked_for() -> None:
    code = "import sys, cramlite.experiment.run\nfrom cramlite.experiment.cluster import check_executor\n"
    code += "check_executor('local'); check_executor('dask')\n"
    code += "print([m for m in ('distributed', 'dask', 'bokeh') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"


def test_something_else_that_answers_is_no_scheduler() -> None:
    def answer(server: socket.socket) -> None:
        while True:
            try:
                with server.accept()[0] as taken:
                    taken.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")
            except OSError:
                return

    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=answer, args=(server,), daemon=True).start()
        with pytest.raises(UserError, match="no Dask scheduler at"), connected(
            f"dask://127.0.0.1:{server.getsockname()[1]}", 1, patience=2
        ):
            pass
