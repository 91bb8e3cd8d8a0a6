#!/usr/bin/env bash
# Fuzzes a target for so many seconds: fuzz/run.sh TARGET SECONDS. Crashes, hangs over 2 s and inputs that take 1 GB of
# memory end it, with the input in fuzz/artifacts/TARGET. What it has learnt stays in fuzz/corpus/TARGET.
set -euo pipefail
cd "$(dirname "$0")"
target=$1 seconds=$2

# the words of a deck are those of its documentation
mkdir -p target "corpus/$target"
grep -ho '`"\?[A-Za-z_0-9-]\+"\?`' ../docs/deck.md | tr -d '`"' | sort -u | sed 's/.*/"&"/' >target/deck.dict
case $target in
  deck) options=(-dict=target/deck.dict) seeds=(seeds/deck) ;;
  point_deck) options=(-dict=target/deck.dict) seeds=(../meshes/point) ;;
  gmsh | abaqus) options=() seeds=("seeds/$target") ;;
  vtk) options=() seeds=(../crates/io/tests/corpus/vtk) ;;
  *) options=(-len_control=0) seeds=() ;;
esac

TMPDIR=$(mktemp -d -p /dev/shm)
export TMPDIR RAYON_NUM_THREADS=1
trap 'rm -rf "$TMPDIR"' EXIT
cargo fuzz run --sanitizer none "$target" "corpus/$target" "${seeds[@]}" -- "${options[@]}" -max_total_time="$seconds" \
  -timeout=2 -rss_limit_mb=1024 -max_len=16384 -close_fd_mask=3 -print_final_stats=1
