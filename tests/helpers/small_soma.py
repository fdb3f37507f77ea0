"""A small ontology with the shape of SOMA, for where its originals are absent."""

from __future__ import annotations

SMALL_SOMA = """
soma:hasDisposition a owl:ObjectProperty .
soma:Cup rdfs:subClassOf soma:Crockery . soma:Crockery rdfs:subClassOf dul:Object . soma:Bottle rdfs:subClassOf dul:Object .
"""
