"""Taxonomy of classes, its OWL files, and consistency checks of ontologies."""
