"""The command line: one module for each larger command, named like the command."""
