#!/usr/bin/env bash
# Draws the plots and the film of docs/guide/launcher.md anew. Needs stillpoint on the path.
set -euo pipefail
cd "$(dirname "$0")/.."
to=docs/guide/launcher
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir -p "$to"
salvo="$folder/salvo.mcap"
stillpoint run scenarios/launcher.toml --quiet --out "$salvo"
plot() {
  local name=$1
  shift
  stillpoint plot "$salvo" "$@" --quiet -o "$to/$name.svg"
}
plot elevation elevation
plot pitch_rate pitch_rate
plot side side
plot heave carrier.z
plot turret turret.angle
plot wheels wheel_fl.distance wheel_fr.distance wheel_rl.distance wheel_rr.distance
plot jacks 'jack front left' 'jack front right' 'jack rear left' 'jack rear right'
plot oil rod.distance
plot flight rocket_1.position.z rocket_4.position.z rocket_8.position.z rocket_12.position.z
plot energy kinetic work dissipated
stillpoint video "$salvo" --quiet --size 480x320 --rate 12 --camera=-60,15 --around 'carrier,wheel*,tubes' -o "$to/salvo.gif"
