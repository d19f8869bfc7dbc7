"""Suites of acceptance: what passes, what each way of failing is called, and how far values may go."""
