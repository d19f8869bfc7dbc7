"""Cases of a plan: joint choices of cells in which every pose is valid.

Start with `pool`; `pool_model` holds the tables that all files share; `grid`, `guillotine`, `free_rectangle` and
`shelf` are the structured layout families.
"""
