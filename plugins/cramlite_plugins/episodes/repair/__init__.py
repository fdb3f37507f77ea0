"""Repair of recorded episodes: flicker, dropouts, two hands."""
