#!/bin/sh
# Make FOLDER an environment whose Python has PyTorch for the CPU, for the tests of runtime_plan.torch_sampler, and LeRobot's
# own library in the last versions that write v2.1 and v3.0, for the tests of replay (380 MB of disk without PyTorch).
# PyPI has no such build for Linux on x86-64; Debian 12 has one for its own Python 3.11 (152 MB to fetch, 651 MB of disk).
# Where that is not to be had, or would need rights that we do not have, FOLDER/left-out says why: those tests then skip with
# these words. Without that file they fail, and so does this where it has all it needs and is refused.
set -eu
own=$1 folder=$2 system=/usr/bin/python3.11
mkdir -p "$folder"
rm -f "$folder/left-out"
left_out() {
  echo "$1" | tee "$folder/left-out"
  exit 0
}
"$own" -c "import torch" 2>/dev/null && left_out "the tests' own Python has PyTorch, LeRobot's library is not brought beside it"
if ! "$system" -c "import torch" 2>/dev/null; then
  line="apt-get update && apt-get install -y --no-install-recommends python3-torch"
  if [ ! -x "$system" ] || ! grep -qs "^VERSION_CODENAME=bookworm" /etc/os-release; then
    left_out "PyTorch for the CPU is not packaged for this system"
  elif [ "$(id -u)" = 0 ]; then
    DEBIAN_FRONTEND=noninteractive sh -c "$line" >/dev/null
  elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    sudo -n DEBIAN_FRONTEND=noninteractive sh -c "$line" >/dev/null
  else
    left_out "PyTorch needs the rights to run: sudo sh -c '$line' && rm -f $folder/.installed (then make again)"
  fi
fi
test -x "$folder/bin/python" || "$system" -m venv --without-pip --system-site-packages "$folder"
"$own" -m pip --python "$folder/bin/python" install --quiet --disable-pip-version-check -c constraints.txt pydantic
lone="--quiet --disable-pip-version-check --no-deps --no-compile"
"$own" -m pip --python "$folder/bin/python" install $lone -r tools/lerobot-requirements.txt
"$own" -m pip --python "$folder/bin/python" install $lone --target "$folder/lerobot-v2.1" lerobot==0.3.3
"$own" -m pip --python "$folder/bin/python" install $lone --target "$folder/lerobot-v3.0" lerobot==0.4.4
