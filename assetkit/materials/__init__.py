"""Materials of one object: colours and finish of its surface, and which substance each part is made of."""
