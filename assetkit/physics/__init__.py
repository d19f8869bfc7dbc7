"""The physics section of one asset: colliders, mass properties, contact materials; read `build` first."""
