"""The taxonomy: reading, closure, affordances, names, bad input, and agreement with OWL-RL and the originals."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import rdflib
from helpers.small_soma import SMALL_SOMA
from hypothesis import given
from hypothesis import strategies as st

from cramlite import data_folder
from cramlite.ontology.check import check_ontology, report_lines
from cramlite.ontology.owl_files import extract
from cramlite.ontology.prefixes import PREFIXES
from cramlite.ontology.taxonomy import Taxonomy, load_taxonomy
from cramlite.plugin import UserError

ORIGINALS = Path(__file__).resolve().parents[3] / "shared" / "data" / "soma"
OURS = data_folder("ontologies")
HEAD = "\n".join(f"@prefix {p}: <{n}> ." for p, n in PREFIXES.items()) + "\n"


@pytest.fixture(scope="module")
def taxonomy(tmp_path_factory: pytest.TempPathFactory) -> Taxonomy:
    return load_taxonomy([OURS], tmp_path_factory.mktemp("cache"))


def write(folder: Path, text: str, name: str = "own.ttl") -> Path:
    path = folder / name
    path.write_text(HEAD + text if name.endswith(".ttl") else text, errors="surrogateescape")
    return path


def test_subclasses_and_their_limits(taxonomy: Taxonomy) -> None:
    assert taxonomy.is_a("artm:ExtractHoleFromPeg", "soma:PhysicalTask")
    assert taxonomy.is_a("soma:LookingFor", "soma:PhysicalTask")
    assert taxonomy.is_a("cram:BoxedProduct", "cram:Product")
    assert not taxonomy.is_a("cram:Product", "cram:BoxedProduct")
    assert not taxonomy.is_a("cram:Hanger", "soma:DesignedContainer")


def test_all_27_task_types_have_a_depth_and_roles(taxonomy: Taxonomy) -> None:
    assert taxonomy.depth("artm:Ungrasping") > taxonomy.depth("soma:Releasing") > taxonomy.depth("soma:PhysicalTask")
    assert set(taxonomy.fillers("soma:Placing", "cram:definesRole")) == {"soma:LocatumRole", "soma:RelatumRole"}


def test_affordances_come_from_restrictions_of_ancestors(taxonomy: Taxonomy) -> None:
    assert taxonomy.affords("cram:Basket", "soma:Containment")
    assert taxonomy.offers("cram:Basket", "soma:hasFeature", "soma:Surface")
    assert not taxonomy.affords("cram:Hanger", "soma:Containment")
    assert taxonomy.fillers("vrps:Hook", "cram:constrainedDof") == (4.0,)


@pytest.mark.parametrize(
    ("name", "meaning"),
    [
        ("HoleOnPeg", "artm:InsertHoleOntoPeg"),
        ("PutDown", "soma:PuttingDown"),
        ("PickUp", "soma:PickingUp"),
        ("Place", "soma:Placing"),
        ("Sliding", "artm:SlidingObject"),
        ("artm:Sliding", "artm:Sliding"),
        ("Shake", "cram:Shaking"),
        ("http://knowrob.org/kb/knowrob_u.owl#GraspingSomething", "cram:GraspState"),
        ("http://knowrob.org/kb/knowrob.owl#Cup", "soma:Cup"),
        ("soma:GraspState", "cram:GraspState"),
        ("http://www.ease-crc.org/ont/SOMA.owl/Grasping", "soma:Grasping"),
        ("Teapot", None),
    ],
)
def test_names_that_users_and_logs_know(taxonomy: Taxonomy, name: str, meaning: str | None) -> None:
    assert taxonomy.resolve(name) == meaning


def test_curies_and_iris(taxonomy: Taxonomy) -> None:
    assert taxonomy.curie(taxonomy.iri("soma:Cup")) == "soma:Cup"
    assert taxonomy.curie("http://nowhere.org/x#y") == "http://nowhere.org/x#y"


def test_users_extend_classes_and_alignment(tmp_path: Path) -> None:
    own = write(
        tmp_path,
        "cram:Candle rdfs:subClassOf cram:Product .\nknowrob:Kerze skos:closeMatch cram:Candle .\n"
        "cram:candle_1 a cram:Candle .",
    )
    taxonomy = load_taxonomy([OURS, own], tmp_path / "cache")
    assert taxonomy.affords("cram:Candle", "soma:Graspability")
    assert taxonomy.resolve("http://anywhere.org/log#Kerze") == "cram:Candle"
    assert taxonomy.instances("cram:Product") == ("cram:candle_1",)


def test_intersections_and_equivalent_classes(tmp_path: Path) -> None:
    own = write(
        tmp_path,
        "cram:A rdfs:subClassOf [ a owl:Class ; owl:intersectionOf ( cram:B cram:C ) ] .\n"
        "cram:C owl:equivalentClass cram:D .",
    )
    taxonomy = load_taxonomy([own], tmp_path / "cache")
    assert taxonomy.ancestors("cram:A") == {"cram:A", "cram:B", "cram:C", "cram:D"}
    assert not taxonomy.is_a("cram:B", "cram:A")


def test_cycles_are_reported_and_harmless(tmp_path: Path) -> None:
    own = write(tmp_path, "cram:A rdfs:subClassOf cram:B . cram:B rdfs:subClassOf cram:A .")
    taxonomy = load_taxonomy([own], tmp_path / "cache")
    assert taxonomy.is_a("cram:A", "cram:B")
    assert taxonomy.is_a("cram:B", "cram:A")
    assert taxonomy.depth("cram:A") == 1
    assert "cram:A, cram:B" in taxonomy.repairs[0]


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("x.owl", "Prefix(:=<http://x#>)\nOntology(<http://x>\nDeclaration(Class(:A))", "line 3: the text ends where the syntax needs"),
        ("x.owl", "Prefix(:=<http://x#>)\nOntology(<http://x>\nSubClassOf(a:A :B))", "line 3: undefined prefix in 'a:A'"),
        ("x.owl", "Prefix(:=<http://x#>)\nOntology(<http://x>))", "line 2: expected .*, found '.'"),
        ("x.ofn", "Ontology(<http://x>\n(<http://x#A>)) (", "line 2: expected .*, found"),
        ("x.owl", "Prefix: : <http://x#>\nOntology: <http://x>\nClass: A", "in Manchester syntax.*robot convert"),
        ("x.owl", '<?xml version="1.0"?>\n<Ontology xmlns="http://www.w3.org/2002/07/owl#"/>', "in OWL/XML.*robot convert"),
        ("x.ttl", "cram:A rdfs:subClassOf", "cannot be read"),
        ("x.ttl", "cram:A a\n\nowl:Class ; x:y cram:B .", r"x\.ttl:\d+: this cannot be read as an ontology: Prefix \"x:\" not bound"),
        ("x.ttl", "cram:A a cram:\udcff .", r"x\.ttl:\d+: this is not UTF-8 text \(byte \d+\)"),
        ("x.ttl", "<http://a b> a x:y .", "not bound"),
        ("x.owl", "<rdf:RDF", r"x\.owl:1: this is not XML"),
        ("x.owl", "\x00\x01", "cannot be read"),
    ],
)
def test_bad_files_are_explained(tmp_path: Path, name: str, text: str, words: str, caplog: pytest.LogCaptureFixture) -> None:
    path = write(tmp_path, text, name)
    with pytest.raises(UserError, match=words) as caught:
        load_taxonomy([path], tmp_path / "cache")
    assert str(path) in str(caught.value) and not caplog.records, "one paragraph, and nothing that rdflib logs"


PREFIXED = """
@prefix cram: <http://cramlite.org/ont/cram.owl#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix skos: <http://www.w3.org/2004/02/skos/core#> .
"""
SAME = """
cram:A a owl:Class ; rdfs:subClassOf [ a owl:Class ; owl:intersectionOf (
    cram:B [ a owl:Restriction ; owl:onProperty cram:has ; owl:someValuesFrom cram:E ] ) ] .
cram:C owl:equivalentClass cram:D . cram:D rdfs:subClassOf cram:B .
cram:A rdfs:subClassOf [ a owl:Restriction ; owl:onProperty cram:weighs ; owl:hasValue 2.5 ] ;
    skos:altLabel "big \\"A\\" (so)" . cram:i a cram:A .
"""
FUNCTIONAL = """# made by hand
Prefix(cram:=<http://cramlite.org/ont/cram.owl#>)
Prefix(skos:=<http://www.w3.org/2004/02/skos/core#>)
Prefix(xsd:=<http://www.w3.org/2001/XMLSchema#>)
Ontology(<http://x> <http://x/1>
Annotation(rdfs:comment "an ontology")
Declaration(Class(cram:A))
# Class: cram:A (A)
SubClassOf(Annotation(rdfs:comment "why \\"so\\"") cram:A ObjectIntersectionOf(cram:B ObjectSomeValuesFrom(cram:has cram:E)))
EquivalentClasses(cram:C cram:D)   SubClassOf(cram:D <http://cramlite.org/ont/cram.owl#B>)
SubClassOf(cram:A DataHasValue(cram:weighs "2.5"^^xsd:decimal))
AnnotationAssertion(skos:altLabel cram:A "big \\"A\\" (so)")
HasKey(cram:A (cram:has) ())
SubObjectPropertyOf(ObjectPropertyChain(cram:has cram:has) cram:has)
ClassAssertion(cram:A cram:i)
)
"""


def test_functional_syntax_says_what_turtle_says(tmp_path: Path) -> None:
    (tmp_path / "one.ttl").write_text(PREFIXED + SAME)
    (tmp_path / "other.owl").write_text(FUNCTIONAL)
    one, other = (extract([(p, p.read_bytes())]) for p in (tmp_path / "one.ttl", tmp_path / "other.owl"))
    assert one["parents"] == other["parents"] and one["parents"]["cram:A"] == ["cram:B"]
    assert [r[:2] for r in one["restrictions"]["cram:A"]] == [r[:2] for r in other["restrictions"]["cram:A"]]
    assert ["cram:weighs", 2.5] in [r[:2] for r in other["restrictions"]["cram:A"]]
    assert one["aliases"] == other["aliases"] == {'big "A" (so)': "cram:A"}
    assert other["types"]["cram:i"] == ["cram:A"]


@pytest.mark.parametrize(("format_", "ending"), [("nt", "nt"), ("json-ld", "jsonld"), ("nt", "owl"), ("xml", "rdf")])
def test_an_ontology_is_read_in_other_syntaxes(tmp_path: Path, format_: str, ending: str) -> None:
    graph = rdflib.Graph().parse(data=PREFIXED + SAME, format="turtle")
    path = tmp_path / f"x.{ending}"
    graph.serialize(path, format=format_, encoding="utf-8")
    assert load_taxonomy([path], tmp_path / "cache").is_a("cram:A", "cram:B")


def test_missing_files_are_explained(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no such ontology"):
        load_taxonomy([tmp_path / "absent.ttl"], tmp_path)


def test_entity_bombs_do_not_explode(tmp_path: Path) -> None:
    entities = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10 if k else "x" * 10}">' for k in range(12))
    text = f'<?xml version="1.0"?><!DOCTYPE r [{entities}]><r>&e11;</r>'
    with pytest.raises(UserError, match=r"bomb\.owl:1: entity 'e1' is nested"):
        load_taxonomy([write(tmp_path, text, "bomb.owl")], tmp_path / "cache")


def test_a_damaged_cache_is_rebuilt(tmp_path: Path) -> None:
    first = load_taxonomy([OURS], tmp_path)
    (stored,) = tmp_path.glob("taxonomy-*.json")
    for damage in ("", "{", "[]", "{}", "null"):
        stored.write_text(damage)
        assert load_taxonomy([OURS], tmp_path).parents == first.parents


def test_second_start_needs_no_rdflib(tmp_path: Path) -> None:
    load_taxonomy([OURS], tmp_path)
    code = (
        f"import sys\nfrom pathlib import Path\nfrom cramlite.ontology.taxonomy import load_taxonomy\n"
        f"load_taxonomy([{str(OURS)!r}], Path({str(tmp_path)!r}))\nassert 'rdflib' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@given(st.dictionaries(st.sampled_from("ABCDEFG"), st.lists(st.sampled_from("ABCDEFG"), max_size=3)))
def test_the_closure_is_transitive_reflexive_and_ends(parents: dict[str, list[str]]) -> None:
    taxonomy = Taxonomy({c: tuple(p) for c, p in parents.items()})
    for a in "ABCDEFG":
        assert taxonomy.is_a(a, a)
        assert taxonomy.depth(a) >= 0
        for b in taxonomy.ancestors(a):
            assert taxonomy.ancestors(b) <= taxonomy.ancestors(a)


@pytest.mark.heavy
def test_shipped_ontologies_agree_with_owl_rl_and_the_originals(tmp_path: Path) -> None:
    against = [ORIGINALS] if ORIGINALS.is_dir() else None
    report = check_ontology([OURS], against, tmp_path)
    assert report.sound, report_lines(report)
    assert report.classes > 150
    assert check_ontology([OURS], against, tmp_path) == report


def test_the_check_finds_contradictions(tmp_path: Path) -> None:
    own = write(tmp_path, "cram:A owl:disjointWith cram:B . cram:x a cram:A , cram:B .")
    assert check_ontology([own], cache=tmp_path).contradictions
    fine = write(tmp_path, "cram:A owl:disjointWith cram:B . cram:x a cram:A .", "fine.ttl")
    assert check_ontology([fine], cache=tmp_path).sound


def test_the_check_compares_with_a_small_soma(tmp_path: Path) -> None:
    theirs = write(tmp_path, SMALL_SOMA, "soma.ttl")
    own = write(tmp_path, "soma:Cup rdfs:subClassOf soma:Bottle . soma:Teapotty rdfs:subClassOf soma:Crockery .")
    report = check_ontology([own], [theirs], tmp_path / "cache")
    assert (report.missing, report.unsupported, report.sound) == (("soma:Teapotty",), ("soma:Cup < soma:Bottle",), False)
    true = write(tmp_path, "soma:Cup rdfs:subClassOf dul:Object .", "true.ttl")
    assert check_ontology([true], [theirs], tmp_path / "cache").sound, "what follows there may be said here"


@pytest.mark.heavy
@pytest.mark.skipif(not ORIGINALS.is_dir(), reason="SOMA and DUL are not here")
def test_the_check_finds_false_claims_about_soma(tmp_path: Path) -> None:
    own = write(tmp_path, "soma:Cup rdfs:subClassOf soma:Bottle . soma:Teapotty rdfs:subClassOf soma:Crockery .")
    report = check_ontology([own], [ORIGINALS], tmp_path)
    assert report.missing == ("soma:Teapotty",)
    assert report.unsupported == ("soma:Cup < soma:Bottle",)
    assert not report.sound
