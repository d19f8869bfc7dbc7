"""Tests of `scenec.plan.document.cases`."""
