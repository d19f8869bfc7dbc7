"""Tests of release folders: the terms of licences."""
