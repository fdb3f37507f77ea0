"""Universal Robots URScript: a typed program as a script."""
