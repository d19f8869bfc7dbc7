"""The physics section of one asset: mass properties, contact materials of its colliders, statements of the source."""
