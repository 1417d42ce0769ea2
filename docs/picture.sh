#!/usr/bin/env bash
# The picture of a scenario, as the Rerun viewer draws it: docs/picture.sh scenarios/pendulum.toml pendulum.png [SECONDS]
# Without SECONDS it is the start of the run. Needs stillpoint and rerun on the path (on a machine without a graphics card
# the packages mesa-vulkan-drivers and libvulkan1), and python3 with Pillow, which cuts out the bodies and makes the file
# small.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export XDG_RUNTIME_DIR=${XDG_RUNTIME_DIR:-$folder}
stillpoint run "$1" --quiet --out "$folder/run.mcap" 2> "$folder/notes" || { cat "$folder/notes" >&2; exit 1; }
stillpoint view "$folder/run.mcap" --quiet --at "${3:-0}" --save "$folder/run.rrd"
rerun "$folder/run.rrd" --headless --window-size 1280x800 --screenshot-to "$folder/window.png" 2> "$folder/log" ||
  { cat "$folder/log" >&2; exit 1; }
python3 - "$folder/window.png" "$2" <<'PYTHON'
import sys
from pathlib import Path
from PIL import Image

window = Image.open(sys.argv[1]).convert("RGB")
width, height = window.size
bodies = window.crop((0, int(0.075 * height), int(0.596 * width), int(0.96 * height)))
# Where something stands that is no background and no grid, with a margin.
def stands(pixel):
    return max(pixel) - min(pixel) > 40 or max(pixel) < 170
small = bodies.resize((bodies.width // 2, bodies.height // 2), Image.Resampling.BOX)
pixels = zip(*(band.tobytes() for band in small.split()))
mask = Image.frombytes("L", small.size, bytes(255 if stands(pixel) else 0 for pixel in pixels))
found = mask.getbbox()
if found is None:
    sys.exit(f"{sys.argv[1]}: nothing is drawn")
left, upper, right, lower = (2 * edge for edge in found)
margin = width // 30
box = (max(left - margin, 0), max(upper - margin, 0), min(right + margin, bodies.width), min(lower + margin, bodies.height))
picture = bodies.crop(box)
# As large and as colourful as 60 kB allow.
for side, colors in [(600, 128), (600, 64), (480, 64), (400, 32), (320, 16)]:
    small = picture.copy()
    small.thumbnail((side, side), Image.Resampling.LANCZOS)
    small.quantize(colors, method=Image.Quantize.MAXCOVERAGE, kmeans=3, dither=Image.Dither.NONE).save(sys.argv[2], optimize=True)
    if Path(sys.argv[2]).stat().st_size <= 60_000:
        break
PYTHON
