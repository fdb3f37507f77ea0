"""A sentence and a scene become goals: a grammar over the words of ontologies, of things and of goal phrases."""
