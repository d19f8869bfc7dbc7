"""Pictures of scenes and of why there is none, seen from above; PNG bytes, equal for equal input."""
