"""The command line: one module for each large command, of the same name, and some for several small commands."""
