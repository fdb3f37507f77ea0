"""Task types: roles, parameters, decompositions and effects of each task, one module for each."""
