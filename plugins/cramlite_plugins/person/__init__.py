"""A simulated person: demonstrations by a hand in MuJoCo."""
