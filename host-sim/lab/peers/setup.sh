#!/usr/bin/env bash
# Creates the environment of the other engines: a Python venv with pinned versions in FOLDER, and the program in rapier/.
# Reports each engine that cannot be installed in one sentence; run.py then skips it.
set -euo pipefail
folder=${1:?give a folder for the Python environment}
here=$(cd "$(dirname "$0")" && pwd)
python3 -m venv "$folder"
"$folder/bin/pip" install --quiet --upgrade pip || true
while read -r package; do
  "$folder/bin/pip" install --quiet "$package" || echo "skipped: $package cannot be installed here"
done <"$here/requirements.txt"
(cd "$here/rapier" && cargo build --release) || echo "skipped: rapier3d cannot be built here"
command -v ccx >/dev/null || echo "skipped: CalculiX (ccx) is missing (Debian: apt-get install calculix-ccx)"
