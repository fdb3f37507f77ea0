"""Recovery of an execution after a stop or a change of the world."""
