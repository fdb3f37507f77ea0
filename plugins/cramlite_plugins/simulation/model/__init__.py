"""The MuJoCo model of a world: built, compiled, indexed."""
