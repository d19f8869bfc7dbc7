"""Roll-outs of mechanisms compiled by Numba: one world at a time, the steps of `sim.dynamics.mechanism`.

`rollout` puts a model, windows and laws into numbers (`inputs`) and calls the kernel of the dynamics' form
(`separate_joints`, `planar_chain`, `tree`). Compiled code is cached on disk beside each source file. The cache of a
function does not notice that a function or constant of another file changed: a kernel keeps all that it calls in
its own file, and after a change of `inputs` the cached files (`*.nbi`, `*.nbc`) are deleted by hand.
"""
