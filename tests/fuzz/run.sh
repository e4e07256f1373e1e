#!/usr/bin/env bash
# Runs every fuzzer of build/fuzz/fuzz for SECONDS each; exit 1 if one finds something.
#   tests/fuzz/run.sh [SECONDS] [NAME...]
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-60}
if (($# > 0)); then shift; fi
[ $# -gt 0 ] || set -- connectivity corrections regions annotations results task_files task_forms task_results continuous_files pose_traces trace vectors store jpeg png hdr zip conf strip \
  mesh_gltf mesh_obj mesh_ply house segmentation safetensors pickle feature_tsv feature_hdf5 subwords decisions navigation habitat_nav_mesh model_answers ask_conversation mcp http_head phases submissions
mkdir -p build/fuzz/found

fuzz() {
  local name=$1 corpus=build/fuzz/corpus/$1
  mkdir -p "$corpus"
  # 64 kB holds any structure; larger inputs only slow the search down.
  if "build/fuzz/fuzz/fuzz_$name" -max_total_time="$seconds" -max_len=65536 -timeout=20 \
    -rss_limit_mb=4096 -print_final_stats=1 -artifact_prefix="build/fuzz/found/$name-" \
    "$corpus" "tests/fuzz/seeds/$name" >"build/fuzz/found/$name.log" 2>&1; then
    echo "$name: nothing found in $(awk '/number_of_executed_units/ {print $2}' "build/fuzz/found/$name.log") runs of $seconds s"
  else
    echo "$name: FOUND SOMETHING, see build/fuzz/found/$name.log"
    return 1
  fi
}
export -f fuzz
export seconds
printf '%s\n' "$@" | xargs -P "$(nproc)" -I{} bash -c 'fuzz "$1"' _ {}
