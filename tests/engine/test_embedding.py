"""cramlite inside other programs: two engines, threads, an asyncio server, cancellation; the results are the same."""

from __future__ import annotations

import asyncio
import json
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from conftest import PLANNED, Proven
from msgspec.structs import replace

from cramlite import Engine, Scenario, Solution, Trace, find_scenario, read_scenario
from cramlite.plugin import UserError

SCENARIO = read_scenario(find_scenario("take_off_hanger_tasks"))
SMALL = read_scenario(find_scenario("grasp_one_thing"))


def _first(engine: Engine, scenario: Scenario = SCENARIO) -> Solution:
    return next(engine.resolve(scenario))


@pytest.fixture(scope="module")
def alone(proven: Proven) -> Solution:
    """What one engine finds with nobody beside it."""
    return proven("take_off_hanger_tasks")


@pytest.fixture(scope="module")
def small(proven: Proven) -> Solution:
    """The same of a scenario with one task."""
    return proven("grasp_one_thing")


@pytest.mark.heavy
@pytest.mark.parametrize("name", [PLANNED, pytest.param("take_off_hanger_tasks", marks=pytest.mark.heavy)])
def test_two_engines_in_two_threads(name: str, proven: Proven) -> None:
    scenario, alone = read_scenario(find_scenario(name)), proven(name)
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(_first, (Engine(), Engine()), (scenario, scenario)))
    for solution in found:
        assert solution.code == alone.code
        assert solution.verdict == alone.verdict
        assert solution.trace.to_json() == alone.trace.to_json()


def test_two_engines_take_turns(small: Solution) -> None:
    first, second = (Engine().resolve(SMALL), Engine().resolve(SMALL))
    one, other = next(first), next(second)
    assert one.code == other.code == small.code
    assert next(first).code == next(second).code != small.code


@pytest.mark.heavy
def test_different_plugins_in_one_process(small: Solution) -> None:
    other = Engine(blocked=["stability"] if "stability" in {i.name for i in Engine().registry.infos} else ["tracks"])
    assert _first(other, SMALL).verdict.passed
    assert _first(Engine(), SMALL).code == small.code


@pytest.mark.heavy
def test_an_asyncio_server(small: Solution) -> None:
    engine, beats = Engine(), []

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        name = (await reader.readline()).decode().strip()
        scenario = read_scenario(find_scenario(name))
        solution = await asyncio.to_thread(lambda: next(engine.resolve(scenario)))
        writer.write(json.dumps({"plan": str(solution.plan), "code": solution.code}).encode() + b"\n")
        await writer.drain()
        writer.close()

    async def beat() -> None:
        while True:
            beats.append(1)
            await asyncio.sleep(0.05)

    async def ask(port: int) -> dict[str, str]:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(b"grasp_one_thing\n")
        line = await reader.readline()
        writer.close()
        return dict(json.loads(line))

    async def both() -> list[dict[str, str]]:
        server = await asyncio.start_server(answer, "127.0.0.1", 0)
        heart = asyncio.create_task(beat())
        port = server.sockets[0].getsockname()[1]
        answers = await asyncio.gather(ask(port), ask(port))
        heart.cancel()
        server.close()
        return answers

    first, second = asyncio.run(both())
    assert first == second == {"plan": str(small.plan), "code": small.code}
    assert len(beats) > 5  # the loop went on while programs were made


def test_stop_from_another_thread() -> None:
    trace, asked = Trace(), threading.Event()

    def progress(_: str) -> None:
        asked.set()

    solutions = Engine().resolve(SCENARIO, trace=trace, progress=progress, stop=asked.is_set)
    assert next(solutions, None) is None
    last = trace.entries[-1]
    assert (last.kind, last.outcome, last.reason) == ("stop", "capped", "stopped by the caller")
    assert not [e for e in trace.entries if e.kind == "proof"]


def test_stop_before_it_begins_and_an_iterator_that_is_dropped() -> None:
    assert list(Engine().resolve(SCENARIO, stop=lambda: True)) == []
    threads = threading.active_count()
    solutions = Engine().resolve(SMALL)
    next(solutions)
    del solutions
    assert threading.active_count() == threads  # nothing runs on


@pytest.mark.heavy
def test_where_a_run_ended_is_where_the_next_begins(alone: Solution) -> None:
    after = alone.setting_after()
    tea = after.world.thing("tea")
    moved = tea.pose.distance(alone.setting.world.thing("tea").pose)[0]
    assert moved > 0.2
    assert ("in", "tea", "basket") in after.relations
    assert after.world.thing("basket") == alone.setting.world.thing("basket")
    held = replace(alone, candidate=replace(alone.candidate, rollout=None))
    with pytest.raises(UserError, match="did not run here"):
        held.setting_after()


def test_import_has_no_side_effects(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    found = _first(Engine(), SMALL)
    assert found.verdict.passed and found.candidate.rollout is not None  # it was planned, written and run from here
    assert list(tmp_path.iterdir()) == []
