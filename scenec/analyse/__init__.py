"""Analysis of a bound scene: its interaction graph and the order in which owners are solved."""
