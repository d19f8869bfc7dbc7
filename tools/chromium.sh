#!/bin/sh
# Install Debian's Chromium for the tests that open Mana's pages in a real browser; where we may not, say so and go on.
command -v chromium >/dev/null 2>&1 && exit 0
line="apt-get update -qq && apt-get install -y --no-install-recommends chromium"
if command -v apt-get >/dev/null 2>&1 && [ "$(id -u)" = 0 ] && sh -c "$line" >/dev/null 2>&1; then
  exit 0
fi
echo "Chromium is not installed, so tests of pages in a browser are skipped. On Debian: sudo sh -c '$line'"
