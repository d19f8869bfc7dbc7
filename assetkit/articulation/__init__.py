"""How the joints of an articulated object are used: group, opening sense, contact, swept volume, anchors of its links.

Read `joint_uses` first. The pure geometry is in `geom.articulation`.
"""
