"""An object drawn in one way from several sides, and a contact sheet: looks, wires, parts, colliders, physics.

Read `request` (what is drawn), `draw` (one table of modes) and then the file of a mode. A new mode is a file with one
function, a row in `draw.MODES`, a word in `request.Mode` and a test.
"""
