#!/usr/bin/env bash
# The picture of a scenario: docs/picture.sh scenarios/pendulum.toml pendulum.png [SECONDS]
# Without SECONDS it is the start of the run. Needs stillpoint on the path, and nothing else.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
stillpoint run "$1" --quiet --out "$folder/run.mcap" 2> "$folder/notes" || { cat "$folder/notes" >&2; exit 1; }
stillpoint picture "$folder/run.mcap" --quiet --at "${3:-0}" --size 720x480 --meshes --out "$2"
