"""Tables as people and instruments write them: text, separators, numbers, units."""
