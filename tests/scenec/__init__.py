"""Tests of `scenec`: programs from text to scene, sessions and proofs."""
