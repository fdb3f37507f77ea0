"""Prefixes of IRIs: conversion to short names (CURIEs) and back."""

from __future__ import annotations

PREFIXES = {
    "dul": "http://www.ontologydesignpatterns.org/ont/dul/DUL.owl#",
    "soma": "http://www.ease-crc.org/ont/SOMA.owl#",
    "artm": "http://www.artiminds.com/kb/artm.owl#",
    "vrps": "http://www.artiminds.com/kb/vr_program_synthesis.owl#",
    "cram": "http://cramlite.org/ont/cram.owl#",
    "knowrob": "http://knowrob.org/kb/knowrob.owl#",
    "owl": "http://www.w3.org/2002/07/owl#",
    "rdf": "http://www.w3.org/1999/02/22-rdf-syntax-ns#",
    "rdfs": "http://www.w3.org/2000/01/rdf-schema#",
    "skos": "http://www.w3.org/2004/02/skos/core#",
    "xsd": "http://www.w3.org/2001/XMLSchema#",
}


def local_name(name: str) -> str:
    """Return the part of a CURIE or IRI after its namespace."""
    for separator in "#/:":
        name = name.rsplit(separator, 1)[-1]
    return name


def curie(iri: str, prefixes: dict[str, str]) -> str:
    """Convert an IRI to its CURIE; unchanged if no prefix fits.

    IRIs of SOMA with a slash in the place of "#" are read as those with "#".
    """
    iri = iri.replace("http://www.ease-crc.org/ont/SOMA.owl/", PREFIXES["soma"])
    for prefix, namespace in prefixes.items():
        if iri.startswith(namespace) and len(iri) > len(namespace):
            return f"{prefix}:{iri[len(namespace) :]}"
    return iri
