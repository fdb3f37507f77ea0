"""Parametric object models: products, fixtures, furniture, vessels, meshes."""
