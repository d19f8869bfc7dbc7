"""Documents of replay: recorded episodes, and what is made of them."""
