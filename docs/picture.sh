#!/usr/bin/env bash
# The picture of a scenario's start, as the Rerun viewer draws it: docs/picture.sh scenarios/pendulum.toml pendulum.png
# Needs stillpoint and rerun on the path, and python3 with Pillow, which cuts out the bodies and makes the file small.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
stillpoint run "$1" --quiet --out "$folder/run.mcap"
stillpoint view "$folder/run.mcap" --quiet --save "$folder/run.rrd"
rerun "$folder/run.rrd" --headless --window-size 1280x800 --screenshot-to "$folder/window.png"
python3 - "$folder/window.png" "$2" <<'PYTHON'
import sys
from PIL import Image

window = Image.open(sys.argv[1]).convert("RGB")
width, height = window.size
bodies = window.crop((0, int(0.075 * height), int(0.596 * width), int(0.96 * height)))
# Where something stands that is darker than the grid, with a margin.
found = bodies.convert("L").point(lambda level: 255 if level < 170 else 0).getbbox()
margin = width // 30
left, upper, right, lower = found
box = (max(left - margin, 0), max(upper - margin, 0), min(right + margin, bodies.width), min(lower + margin, bodies.height))
picture = bodies.crop(box)
picture.thumbnail((720, 560), Image.Resampling.LANCZOS)
picture.quantize(256, method=Image.Quantize.MAXCOVERAGE, kmeans=3, dither=Image.Dither.NONE).save(sys.argv[2], optimize=True)
PYTHON
