# Part of enfilade.sh: the libraries of another kind of machine, to cross-compile for it.
# shellcheck shell=bash disable=SC2154  # needs is packages.sh's

# What is compiled against, by the same names as on this machine; programs, and what only they need,
# are this machine's own.
sysroot_packages() {
  printf 'libc6-dev\nlibstdc++-%s-dev\n' "$(aarch64-linux-gnu-g++ -dumpversion | cut -d . -f 1)"
  awk '$1 ~ /^(build|web|test)$/ && $2 ~ /^(lib|zlib|nlohmann|node-d3)/ && $2 !~ /torch|openblas/ { print $2 }' \
    <<<"$needs"
}

# apt_of_sysroot FOLDER ARGS: apt-get for arm64 with lists and a state of its own in FOLDER: the
# packages of this machine are neither asked nor touched, so that it needs no root.
apt_of_sysroot() {
  local folder=$1
  shift
  mkdir -p "$folder"/{lists/partial,archives/partial}
  : >>"$folder/status"
  {
    printf 'APT::Architecture "arm64";\nAPT::Architectures { "arm64"; };\nAPT::Sandbox::User "%s";\n' "$(id -un)"
    printf 'Dir::State "%s";\nDir::State::lists "%s/lists";\nDir::State::status "%s/status";\n' \
      "$folder" "$folder" "$folder"
    printf 'Dir::Cache "%s";\nDir::Cache::archives "%s/archives";\n' "$folder" "$folder"
    if grep -q '^ID=ubuntu' /etc/os-release; then  # whose main mirrors have no arm64
      # shellcheck source=/dev/null
      (. /etc/os-release && printf 'deb http://ports.ubuntu.com/ubuntu-ports %s main universe\n' \
        "$VERSION_CODENAME" "$VERSION_CODENAME-updates" "$VERSION_CODENAME-security") >"$folder/sources.list"
      printf 'Dir::Etc::sourcelist "%s/sources.list";\nDir::Etc::sourceparts "-";\n' "$folder"
    fi
  } >"$folder/apt.conf"
  APT_CONFIG=$folder/apt.conf apt-get -q -y -o Acquire::Retries=3 "$@"
}

# unpack_sysroot PACKAGES_FOLDER ROOT: lays out the packages' files; none of their scripts is run.
unpack_sysroot() {
  local archive link target
  mkdir -p "$2"/usr/{bin,sbin,lib,lib64}
  for link in bin sbin lib lib64; do
    ln -s "usr/$link" "$2/$link"  # as on every machine since Debian 12
  done
  for archive in "$1"/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$archive" | tar -C "$2" -x --keep-directory-symlink --no-same-owner
  done
  # What a script of libhdf5-dev would have linked.
  ln -s hdf5-serial.pc "$2/usr/lib/aarch64-linux-gnu/pkgconfig/hdf5.pc"
  # Links like libz.so -> /lib/... would lead to this machine's files.
  find "$2" -lname '/*' | while read -r link; do
    target=$(readlink "$link")
    [[ ! -e $2$target ]] || ln -sfnr "$2$target" "$link"
  done
}

# ensure_sysroot FOLDER: what Enfilade is built on, for arm64, in FOLDER; made anew when the list changes.
ensure_sysroot() {
  local folder=$1 packages work=$1-packages
  packages=$(sysroot_packages | sort -u)
  [[ "$(cat "$folder/packages.txt" 2>/dev/null)" != "$packages" ]] || return 0
  command -v apt-get >/dev/null ||
    die 3 "the libraries for ARM are unpacked from Debian's or Ubuntu's packages, and this is neither;" \
      "cmake --preset aarch64 -DEN_SYSROOT=FOLDER takes those of an ARM machine"
  say "unpacking libraries for ARM in $folder (100 MB of packages; this machine's own stay as they are)"
  rm -rf "$folder" "$work"
  mkdir -p "$work"
  work=$(cd "$work" && pwd)
  # shellcheck disable=SC2086
  { apt_of_sysroot "$work" update &&
    apt_of_sysroot "$work" install --download-only --no-install-recommends $packages; } \
    >"$folder.log" 2>&1 || {
    tail -n 20 "$folder.log" >&2
    die 3 "the packages for ARM could not be fetched (all of the output: $folder.log)"
  }
  unpack_sysroot "$work" "$folder"
  rm -rf "$work"
  printf '%s\n' "$packages" >"$folder/packages.txt"
}
