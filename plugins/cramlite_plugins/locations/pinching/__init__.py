"""Pinching: pairs of contacts on a thing between two pads, ranked, and the room that a hand has there."""
