"""The PyBullet implementation of `sim.port` and of the roll-outs in `sim.dynamics`; the only importer of pybullet.

`simulator` lists the engine's traps; `world` and `shapes` build bodies, `windows` what roll-outs share.
"""
