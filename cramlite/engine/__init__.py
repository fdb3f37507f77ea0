"""The engine: a goal in a setting becomes proven programs."""
