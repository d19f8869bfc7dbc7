"""Tests of `scenec.bind.check_assets`."""
