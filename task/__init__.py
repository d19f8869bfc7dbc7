"""Tasks as partial-order graphs, judged from a state log alone: no simulator, no file, no clock.

Read `graph` (nodes and edges), `judge` (the equations over a whole log), `online` (the same, frame by frame), `labels`
and `scores`; `predicates` has one file for each condition that a node may state.
"""
