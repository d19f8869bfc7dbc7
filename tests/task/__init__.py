"""Tests of the task graph: equations against an oracle, predicates, whole and online judgement."""
