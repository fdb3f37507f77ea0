"""Corpus of edited programs: proven programs, rules that corrupt them or change nothing, and oracles on the tracks of the run."""
