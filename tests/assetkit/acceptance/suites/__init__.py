"""Tests of the suites of acceptance, one file per suite; `crates` and `subjects` make what they run on."""
