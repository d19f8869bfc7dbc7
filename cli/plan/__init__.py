"""`mana plan`: sample, inspect, verify, restrict, realise and draw sampling plans."""
