"""Placing: stable poses of a payload, the ways between them and free space, and the checks of both."""
