"""Predicates made of predicates: all, any, not, counted, in sequence, for a time; and those about attributes."""
