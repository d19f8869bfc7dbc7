"""The effects library: one file per physical effect that a simulation may lack; `library.EFFECTS` lists them.

`sim.dynamics.hooks` defines an effect; docs/contributing has a worked page.
"""
