"""Laws that hold for any input: properties, fuzzing, invariants of the source tree."""
