#!/usr/bin/env bash
# Runs a command on a bare Debian that has Python, venv and pip, as somebody who installs a wheel there.
#
#   packaging/bare_root.sh SUITE FOLDER COMMAND...
#
# SUITE is bullseye, bookworm, trixie or another of the archive. The root is made once by debootstrap and kept
# as a tar file in ROOTS (default: build/roots); each run unpacks a new one, and leaves nothing. FOLDER is
# copied to /given there, where COMMAND runs, as root, with an environment of its own but for pip's settings.
# Needs root, debootstrap and 1 GB of disk. MIRROR names a mirror of Debian's archive. ARCHITECTURE=arm64 makes
# a Debian for that, which this machine's kernel must be able to run, as it can with qemu-user-static.
# CACHE names a folder that is the root's ~/.cache: a compiler cache there outlives the run.
set -euo pipefail
[[ $# -ge 3 ]] || { sed -n '2,11p' "$0"; exit 2; }
if [[ -z "${BARE_ROOT_INSIDE:-}" ]]; then  # mounts vanish with this process
  exec env BARE_ROOT_INSIDE=1 unshare --mount --propagation private -- "$0" "$@"
fi
suite=$1 folder=$2
shift 2
roots=${ROOTS:-build/roots}
mkdir -p "$roots"
architecture=${ARCHITECTURE:-$(dpkg --print-architecture)}
base=$roots/$suite-$architecture.tar

if [[ ! -e $base ]]; then
  root=$(mktemp -d -p "$roots")
  debootstrap --arch="$architecture" --variant=minbase --include=ca-certificates,python3,python3-venv,python3-pip \
    "$suite" "$root" "${MIRROR:-http://deb.debian.org/debian}" >"$base.log" 2>&1 || {
    tail -n 5 "$base.log" >&2
    exit 1
  }
  rm -rf "$root"/var/cache/apt/archives/*.deb
  tar -C "$root" -cf "$base.new" . && mv "$base.new" "$base"
  rm -rf --one-file-system "$root"
fi

root=$(realpath "$(mktemp -d -p "$roots")")
clean() {
  local place
  for place in "$root/root/.cache" "$root/proc" "$root/sys" "$root/dev"; do
    if mountpoint -q "$place"; then umount -R -l "$place"; fi
  done
  rm -rf --one-file-system "$root"
}
trap clean EXIT
tar -C "$root" -xf "$base"
chmod 755 "$root"
# How this machine reaches the network: names, certificates, settings of pip and npm.
for file in /etc/resolv.conf /etc/hosts /etc/ssl/certs /etc/pip.conf /etc/npmrc /usr/etc/npmrc "$HOME/.config/pip" \
  "$HOME/.npmrc"; do
  [[ -e $file ]] || continue
  to=$root${file/#$HOME//root}  # there the user is root
  mkdir -p "${to%/*}"
  rm -rf "${to:?}"  # its links lead out of the root
  # Links to certificates that have gone cannot be followed; the others are enough.
  cp -aL "$file" "${to%/*}/" || echo "bare_root: not all of $file could be copied" >&2
done
mapfile -t settings < <(env | sed -nE '/^(PIP_|npm_config_|NODE_EXTRA|https?_proxy=|HTTPS?_PROXY=|SSL_CERT)/p')
mount -t proc proc "$root/proc"
for place in sys dev; do
  mount --rbind "/$place" "$root/$place"
  mount --make-rslave "$root/$place"
done
if [[ -n ${CACHE:-} ]]; then
  mkdir -p "$CACHE" "$root/root/.cache"
  mount --bind "$CACHE" "$root/root/.cache"
fi
cp -a "$folder" "$root/given"
chroot "$root" /usr/bin/env -i HOME=/root LANG=C.UTF-8 PATH=/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin \
  "${settings[@]}" CI="${CI:-}" sh -c 'cd /given && exec "$@"' sh "$@"
