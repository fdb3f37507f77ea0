"""cramlite query and cramlite ontology check, and ontologies that users add."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.as_a_user import cramlite
from helpers.small_soma import SMALL_SOMA

from cramlite import Engine, data_folder
from cramlite.cli.main import main
from cramlite.ontology.prefixes import PREFIXES

EPISODE = str(data_folder("scenarios") / "fetch_from_hanger" / "demonstration")
ORIGINALS = Path(__file__).resolve().parents[3] / "shared" / "data" / "soma"
HEAD = "\n".join(f"@prefix {p}: <{n}> ." for p, n in PREFIXES.items()) + "\n"


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CRAMLITE_CACHE", str(tmp_path / "cache"))


def own(folder: Path, text: str) -> Path:
    (folder / "own.ttl").write_text(HEAD + text)
    return folder / "own.ttl"


def test_a_query_joins_an_episode_with_the_ontologies(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    query = "SELECT DISTINCT ?class WHERE { ?thing a ?class . ?class rdfs:subClassOf+ cram:Product }"
    (tmp_path / "q.rq").write_text(query)
    assert main(["query", f"@{tmp_path / 'q.rq'}", "--episode", EPISODE, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["columns"] == ["class"]
    assert found["rows"]
    assert main(["query", query]) == 0
    assert capsys.readouterr().out.endswith("0 rows\n")


def test_ask_and_construct(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["query", "ASK { soma:Placing rdfs:subClassOf soma:PhysicalTask }"]) == 0
    assert "True" in capsys.readouterr().out
    assert main(["query", "CONSTRUCT { ?c a owl:Thing } WHERE { ?c rdfs:subClassOf artm:Sliding }"]) == 0
    assert "artm:SlidingObject" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["SELECT ?x WHERE {"], "no SPARQL query"),
        (["DELETE WHERE { ?a ?b ?c }"], "no SPARQL query"),
        (["@/nowhere.rq"], "cannot be read"),
        (["ASK {}", "--episode", "/nowhere"], "no episode at"),
    ],
)
def test_bad_queries_are_explained(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["query", *arguments]) == 2
    shown = capsys.readouterr().err
    assert words in shown
    assert "Traceback" not in shown


def test_the_check_command(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["ontology", "check", str(own(tmp_path, "cram:A rdfs:subClassOf cram:B ."))]) == 0
    assert "sound" in capsys.readouterr().out
    wrong = own(tmp_path, "cram:A owl:disjointWith cram:B . cram:x a cram:A , cram:B .")
    assert main(["ontology", "check", str(wrong), "--json"]) == 2
    assert json.loads(capsys.readouterr().out)["contradictions"]
    assert main(["ontology", "check", str(tmp_path / "absent.ttl")]) == 2
    assert "no such ontology" in capsys.readouterr().err


CLAIMS = [
    ("soma:Cup rdfs:subClassOf soma:Crockery , [ owl:onProperty soma:hasDisposition ] .", 0, "sound"),
    ("soma:Teapotty rdfs:subClassOf soma:Crockery .", 2, "missing: soma:Teapotty"),
    ("soma:Cup rdfs:subClassOf [ owl:onProperty soma:hasTemper ] .", 2, "missing: soma:hasTemper"),
    ("soma:Cup rdfs:subClassOf soma:Bottle .", 2, "unsupported: soma:Cup < soma:Bottle"),
]


@pytest.mark.parametrize(("text", "code", "words"), CLAIMS)
def test_the_command_compares_with_a_small_soma(text: str, code: int, words: str, tmp_path: Path) -> None:
    theirs = tmp_path / "soma.ttl"
    theirs.write_text(HEAD + SMALL_SOMA)
    done = cramlite("ontology", "check", own(tmp_path, text), "--against", theirs)
    assert done.returncode == code, done.stderr
    assert words in done.stdout


@pytest.mark.heavy
@pytest.mark.skipif(not ORIGINALS.is_dir(), reason="SOMA and DUL are not here")
@pytest.mark.parametrize(("text", "code", "words"), [(None, 0, "sound"), *CLAIMS])
def test_the_command_compares_with_soma(
    text: str | None, code: int, words: str, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """The command is used as by its users: on the shipped ontologies (no file named) or on one of theirs."""
    files = [] if text is None else [str(own(tmp_path, text))]
    monkeypatch.setenv("CRAMLITE_CACHE", str(tmp_path_factory.getbasetemp() / "originals"))  # read once for all cases
    done = cramlite("ontology", "check", *files, "--against", ORIGINALS)
    assert done.returncode == code, done.stderr
    assert words in done.stdout


def test_users_add_ontologies_by_hook(tmp_path: Path) -> None:
    path = own(tmp_path, "cram:Candle rdfs:subClassOf cram:Product .")
    plugin = tmp_path / "candles.py"
    plugin.write_text(
        "from pathlib import Path\nfrom cramlite.plugin import hookimpl\n\n@hookimpl\ndef ontologies():\n"
        f"    return [Path({str(path)!r})]\n"
    )
    assert Engine(files=[plugin]).knowledge.taxonomy.is_a("cram:Candle", "cram:Product")
    assert Engine().knowledge.taxonomy.resolve("cram:Candle") is None


def test_users_add_ontologies_to_an_engine_as_a_scenario_does(tmp_path: Path) -> None:
    path = own(tmp_path, "cram:Candle rdfs:subClassOf cram:Product .\nknowrob:Kerze skos:closeMatch cram:Candle .")
    taxonomy = Engine(ontologies=[path]).knowledge.taxonomy
    assert taxonomy.resolve("http://knowrob.org/kb/knowrob.owl#Kerze") == "cram:Candle"
    assert taxonomy.resolve("http://knowrob.org/kb/knowrob.owl#Cup") == "soma:Cup"


def test_a_huge_file_is_refused_before_it_is_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with (tmp_path / "huge.ttl").open("wb") as file:
        file.truncate(300_000_000)
    assert main(["ontology", "check", str(tmp_path / "huge.ttl")]) == 2
    assert "300 MB is more than" in capsys.readouterr().err


@pytest.mark.parametrize("lines", ["['no triple']", "[None]", "(1 / 0 for _ in 'x')"])
def test_what_a_plugin_gives_as_triples_and_is_none_is_said(lines: str, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    plugin = tmp_path / "odd.py"
    plugin.write_text(f"from cramlite.plugin import hookimpl\n@hookimpl\ndef episode_triples(episode):\n    return {lines}\n")
    assert main(["query", "ASK {}", "--episode", EPISODE, "--plugin", str(plugin)]) == 3
    said = capsys.readouterr().err
    assert "(episode_triples) are no N-Triples: " in said and said.count("\n") == 1
