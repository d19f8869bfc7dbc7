"""Mass, density and inertia of one object with bounds, from statements, materials, walls or category.

Read `estimate` first; `parts` assigns bodies to substances, `bounds` computes the bounds.
"""
