"""The simulator plugin: execution of programs, demonstrations and pictures of a world, by MuJoCo."""
