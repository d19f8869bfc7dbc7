"""Pictures of a gap that a person understands in ten seconds; PNG bytes, equal for equal input."""
