"""Judges: processes that simulate episodes somebody else defined, and the scenes of these episodes as scenarios."""
