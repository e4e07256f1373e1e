#!/bin/sh
# recorded.sh scores|doubtful_inputs CHECK_VECTORS: compares what public scorers said with ours, or
# docs/doubtful.md with what ours does. 77, a skipped test, where the recordings are not there.
set -eu
what=$1 check_vectors=$2
if [ -z "${ENFILADE_DATA:-}" ]; then
  echo "ENFILADE_DATA is not set: no recorded scores"
  exit 77
fi
folder=$ENFILADE_DATA/../reference/benchmarks_public
if ! [ -d "$folder" ]; then
  echo "no recorded scores beside ENFILADE_DATA"
  exit 77
fi
if [ "$what" = scores ]; then
  exec "$check_vectors" "$folder"/*.json
fi
page=$(cd "$(dirname "$0")/../.." && pwd)/docs/doubtful.md
cd "$folder"
exec "$check_vectors" --doubtful --page "$page" r2r_back.json r4r.json rxr.json reverie.json \
  cvdn.json soon.json vlnce.json
