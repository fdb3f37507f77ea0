"""The engine, which turns a goal for a given world and robot into proven programs."""
