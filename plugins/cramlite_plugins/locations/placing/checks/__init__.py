"""Checks of placements: of shapes, of hand and arm, and of how a payload comes to rest."""
