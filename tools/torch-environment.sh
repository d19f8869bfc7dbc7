#!/bin/sh
# Make FOLDER an environment whose Python has PyTorch, for the tests of runtime_plan.torch_sampler, and LeRobot's own library
# in the last versions that write v2.1 and v3.0, for the tests of replay (380 MB of disk without PyTorch).
# Debian 12 has a small build of PyTorch for its own Python 3.11 (152 MB to fetch, 651 MB of disk): taken where we may
# install packages. Elsewhere it comes from PyPI, which for Linux on x86-64 has only the build for graphics cards (5 GB of disk).
set -eu
own=$1 folder=$2 system=/usr/bin/python3.11
line="apt-get update && apt-get install -y --no-install-recommends python3-torch"
quiet="--quiet --disable-pip-version-check"

if [ -x "$system" ] && grep -qs "^VERSION_CODENAME=bookworm" /etc/os-release && ! "$system" -c "import torch" 2>/dev/null; then
  if [ "$(id -u)" = 0 ]; then
    DEBIAN_FRONTEND=noninteractive sh -c "$line" >/dev/null
  elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    sudo -n DEBIAN_FRONTEND=noninteractive sh -c "$line" >/dev/null
  fi
fi
if "$system" -c "import torch" 2>/dev/null; then
  "$system" -m venv --without-pip --system-site-packages "$folder"
else
  "$own" -m venv --without-pip "$folder"
  "$own" -m pip --python "$folder/bin/python" install $quiet -r tools/torch-requirements.txt
fi
"$own" -m pip --python "$folder/bin/python" install $quiet -c constraints.txt pydantic
lone="$quiet --no-deps --no-compile"
"$own" -m pip --python "$folder/bin/python" install $lone -r tools/lerobot-requirements.txt
"$own" -m pip --python "$folder/bin/python" install $lone --target "$folder/lerobot-v2.1" lerobot==0.3.3
"$own" -m pip --python "$folder/bin/python" install $lone --target "$folder/lerobot-v3.0" lerobot==0.4.4
