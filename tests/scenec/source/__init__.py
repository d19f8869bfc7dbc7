"""Tests of `scenec.source`: parsing, validation and checks of program texts."""
