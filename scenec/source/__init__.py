"""From the text of a scene program to its model: parse, resolve includes, check; every value keeps where it stood."""
