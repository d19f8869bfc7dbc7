"""Suites of acceptance: what a role promises is exercised in simulation, one file per suite, listed in `table`.

Read in this order: `suite` (protocol and data), `policy` (bounds), `subject` (what is read from a package), the suites,
`table`, `run` (nominal values), `margins` (corners of friction and mass).
"""
