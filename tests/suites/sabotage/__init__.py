"""Sabotage of released packages, to prove that acceptance can fail: damage by seed, and who must notice it.

Read in this order: `package` (a copy on disk that is edited), `rigid` and `mechanisms` (the kinds of damage), `table`
(kind and the codes that must name it, written before any run), `run` (apply, accept, count).
"""
