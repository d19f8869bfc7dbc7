# OpenUSD ships no types: its modules fill their names at import, so pyright finds none. Every name is `Any` here.
