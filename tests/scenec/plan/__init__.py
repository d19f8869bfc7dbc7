"""Tests of `scenec.plan`: sampling plans and their cases."""
