#!/bin/sh
# recorded_agents.sh CHECK_AGENTS: compares what published agents computed with ours. 77, a skipped
# test, where the recordings are not there.
set -eu
check_agents=$1
if [ -z "${ENFILADE_DATA:-}" ]; then
  echo "ENFILADE_DATA is not set: no recorded agents"
  exit 77
fi
folder=$ENFILADE_DATA/../reference/agents_golden
if ! [ -d "$folder" ]; then
  echo "no recorded agents beside ENFILADE_DATA"
  exit 77
fi
exec "$check_agents" "$folder"
