"""`mana task`: task graphs shown, and state logs judged by them."""
