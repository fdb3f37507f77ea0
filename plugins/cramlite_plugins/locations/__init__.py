"""Location resolvers: grasps, handles, pegs, places, base stands, viewpoints, from a belief."""
