"""Tests of `scenec.plan.cases`: layout families and slots."""
