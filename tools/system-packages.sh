#!/bin/sh
# Install the shared libraries that the Python wheels need but do not carry; ask for the one line when we may not.
set -eu
missing=""
need() { ldconfig -p 2>/dev/null | grep -q "$1" || missing="$missing $2"; }
need libGL.so.1 libgl1
need libEGL.so.1 libegl1
need libOpenGL.so.0 libopengl0
need libusb-1.0.so.0 libusb-1.0-0
need libOSMesa.so.8 libosmesa6
need libgomp.so.1 libgomp1
[ -n "$missing" ] || exit 0
line="apt-get update && apt-get install -y --no-install-recommends$missing"
if ! command -v apt-get >/dev/null 2>&1; then
  echo "These Debian packages (or their like) are needed:$missing"
  exit 2
fi
if [ "$(id -u)" = 0 ]; then
  sh -c "$line"
elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
  sudo -n sh -c "$line"
else
  echo "System libraries are missing. Run this line, then make again:"
  echo "  sudo sh -c '$line'"
  exit 2
fi
