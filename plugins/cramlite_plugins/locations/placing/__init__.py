"""Placing: stable poses of a payload, ways out of them into the open, and the checks of both."""
