"""The taxonomy of classes, its files, and the check of an ontology."""
