"""Pushing: a contact of the hand, and a motion of the body that is pushed."""
