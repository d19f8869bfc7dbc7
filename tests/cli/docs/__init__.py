"""Tests of `cli.docs.diagnostics`."""
