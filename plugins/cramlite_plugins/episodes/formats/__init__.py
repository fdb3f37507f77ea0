"""Episode formats: NEEM, mongodump, RobCoG, SOMA, XML graphs, JSON frames."""
