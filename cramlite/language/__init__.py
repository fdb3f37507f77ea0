"""Translation of English sentences about a scene to goals: a grammar over the words of ontologies, of thing names and of goal phrases."""
