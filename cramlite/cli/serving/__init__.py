"""Requests of other software: ``cramlite serve`` and ``cramlite mcp``, and which programs a client may run."""
