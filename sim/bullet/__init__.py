"""The PyBullet implementation of `sim.port` and of the roll-outs in `sim.dynamics`; the only importer of pybullet.

`simulator` lists the engine's traps; `world` and `shapes` build bodies, `windows` what roll-outs share. The module is
imported here for the first time, because that import writes a line to the terminal.
"""

from sim.bullet.quiet_import import import_pybullet

import_pybullet()
