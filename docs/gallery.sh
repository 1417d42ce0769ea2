#!/usr/bin/env bash
# Renders every picture of docs/gallery.md anew, or those that are named: docs/gallery.sh [NAME...]. Needs stillpoint on the path.
# The plots are those that the commands in gallery.md write.
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p docs/gallery
# `![...](gallery/NAME.png)` preceded by a line that names the scenario, and perhaps `at SECONDS s`.
sed -nE 's/^\*\*.*`scenarios\/([a-z_0-9\/]+)\.toml`( at ([0-9.]+) s)?.*/\1 \3/p' docs/gallery.md | while read -r name seconds; do
  if [ $# -gt 0 ] && [[ " $* " != *" ${name##*/} "* ]]; then continue; fi
  echo "$name ${seconds:-0} s"
  docs/picture.sh "scenarios/$name.toml" "docs/gallery/${name##*/}.png" "${seconds:-0}" < /dev/null
done
