"""Tests of `cli.demo.app`."""
