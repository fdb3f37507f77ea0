"""The picture of a reading: nothing is lost from it silently, it is a sound page, and it says what people would say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.page_checks import faults
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite import Engine, data_folder
from cramlite.cli.main import main
from cramlite.model import Entity, Episode, Event
from cramlite.report.interpretation_page import write_interpretation_page
from cramlite.report.reading_picture import LANES, reading_picture
from cramlite.report.spoken_names import spoken_names

FETCH = Path(data_folder("scenarios")) / "fetch_from_hanger" / "demonstration"


@pytest.fixture(scope="module")
def engine() -> Engine:
    return Engine()


@pytest.fixture(scope="module")
def fetch(engine: Engine) -> Episode:
    return engine.read_episode(FETCH)


def drawn(picture: str) -> int:
    return len(re.findall(r'class="state ', picture))


def folded(picture: str) -> int:
    found = re.search(r"and (\d+) more state", picture)
    return int(found[1]) if found else 0


def busy(episode: Episode, count: int) -> Episode:
    """With contacts of plates that have nothing to do with what the person does."""
    plates = [Entity(f"plate_{k}", ("soma:Plate",)) for k in range(21)]
    events = [
        Event(f"busy_{k}", "soma:ContactState", "state", 0.0, 8.0, {"a": f"plate_{k % 20}", "b": f"plate_{k % 20 + 1}"})
        for k in range(count)
    ]
    return replace(episode, entities=(*episode.entities, *plates), events=(*episode.events, *events))


def test_page_is_sound_and_says_why_the_runner_up_lost(tmp_path: Path, engine: Engine, fetch: Episode) -> None:
    found = engine.interpret(fetch)
    write_interpretation_page(tmp_path / "page.html", fetch, found)
    page = (tmp_path / "page.html").read_text("utf-8")
    assert not faults(page)
    assert "the tea is pulled off the peg of the shop hanger" in page
    best, other = list(found.sequences())[:2]
    more = other.length.bits - best.length.bits
    assert more > 0
    assert f"takes {more:.1f} bits more to say" in page
    assert page.count("<script") == 0


def test_terms_of_the_actions_add_up_to_the_whole(engine: Engine, fetch: Episode) -> None:
    for sequence in list(engine.interpret(fetch).sequences())[:5]:
        assert sum(one.bits for one in sequence.lengths) == pytest.approx(-sequence.score)
        assert str(sequence.length) == sequence.reason


@examples(10)
@given(count=st.integers(0, 300))
def test_every_state_is_drawn_or_counted(count: int) -> None:
    episode = busy(Engine().read_episode(FETCH), count)
    picture = reading_picture(episode, None)
    assert drawn(picture) + folded(picture) == len(episode.of("state"))


def test_states_that_no_reading_speaks_of_are_folded_and_those_that_matter_stay(engine: Engine, fetch: Episode) -> None:
    episode = busy(fetch, 300)
    picture = reading_picture(episode, engine.interpret(episode))
    assert folded(picture) == 300
    assert drawn(picture) == len(fetch.of("state"))
    assert picture.count('text-anchor="end">') <= LANES + 3 + 4  # lanes, readings, headings


def test_reading_that_became_a_program_is_the_one_shown(engine: Engine, fetch: Episode) -> None:
    found = engine.interpret(fetch)
    picture = reading_picture(fetch, found, 2)
    assert "Reading no. 2, which was used" in picture
    assert "bits less to say, but no program of it was proven" in picture
    assert "Why the runner-up lost" not in picture


def test_episode_that_nobody_can_explain(engine: Engine) -> None:
    assert "no states and no actions" in reading_picture(Episode("nothing", (), ()), None)
    strange = Episode("strange", (), (Event("e", "x:Y", "state", 0.0, 1.0, {"p": "<b>", "q": "é"}),))
    picture = reading_picture(strange, engine.interpret(strange))
    assert "<b>" not in picture
    assert "There is no other reading" in picture


def test_command_writes_the_page_and_refuses_a_folder_that_is_not_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["interpret", str(FETCH), "--html", str(tmp_path / "page.html")]) == 0
    assert "page.html" in capsys.readouterr().out
    assert main(["interpret", str(FETCH), "--html", str(tmp_path / "no" / "page.html")]) == 2
    assert "cannot be written" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("SM_BigBowl", "big bowl"), ("SK_GenesisRightHand", "genesis right hand"), ("contents(SM_BigBowl)", "contents of the big bowl"),
        ("support(cup)", "place of the cup"), ("support(cup)_2", "new place of the cup"), ("shop_hanger/peg", "peg of the shop hanger"),
        ("http://x.org/map.owl#Cup_7", "cup 7"), ("LED2", "LED2"), ("__", "__"), ("ÜberTasse", "über tasse"),
    ],
)  # fmt: skip
def test_names_are_said_as_people_say_them(name: str, said: str) -> None:
    assert spoken_names([name])(name) == said


@given(st.lists(st.text(max_size=12), unique=True, max_size=8))
def test_two_things_are_never_called_the_same(names: list[str]) -> None:
    said = spoken_names(names)
    assert len({said(n) for n in names}) == len(names)


def test_article_is_not_said_twice() -> None:
    said = spoken_names(["hand", "SM_Cup", "support(SM_Cup)"])
    sentence = said.text("the empty hand lifts SM_Cup off support(SM_Cup)", ["hand", "SM_Cup", "support(SM_Cup)"])
    assert sentence == "the empty hand lifts the cup off the place of the cup"
