#!/bin/sh
# On a machine with Python alone: installs the wheel that lies here, and checks it, then that of habitat_sim. Prints how
# long it took from `pip install` until a home was served.
set -eu
python3 --version
python3 -m venv /tmp/env
start=$(date +%s%N)
/tmp/env/bin/pip install -q --find-links . enfilade
installed=$(date +%s%N)
cd /tmp
/tmp/env/bin/enfilade serve --port 0 >serve.log 2>&1 &
server=$!
until grep -q ' at http://' serve.log; do
  kill -0 $server 2>/dev/null || { cat serve.log; exit 1; }
  sleep 0.1
done
address=$(sed -n 's/.* at \(http:[^ ]*\)$/\1/p' serve.log)
/tmp/env/bin/python - "$address" <<'PYTHON'
import json, sys, urllib.request
read = lambda path: urllib.request.urlopen(sys.argv[1] + path).read()
read("")
scan = json.loads(read("api/v1/scans"))["scans"][0]["scan"]
read(f"api/v1/scans/{scan}/picture.jpg")
PYTHON
served=$(date +%s%N)
kill $server
wait $server  # it ends in order: 0
echo "pip install: $(((installed - start) / 1000000)) ms; a home in the browser after $(((served - start) / 1000000)) ms"
/tmp/env/bin/python /given/check_wheel.py
/tmp/env/bin/pip install -q --find-links . enfilade-habitat
/tmp/env/bin/python /given/check_wheel.py Habitat
