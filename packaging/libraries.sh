#!/usr/bin/env bash
# Makes what wheels are linked with: static libraries, and the C library of an older Debian to link against.
#
#   packaging/libraries.sh OUT [x86_64 | aarch64]
#
# OUT/sysroot    headers and libraries: the C library of Debian 11 (glibc 2.31), and static libraries of
#                Debian 12 that it has, taken from their packages
# OUT/prefix     the others, built from the sources in Debian's archive: static, position independent
# OUT/toolchain.cmake   makes CMake use both, and nothing else of this machine but compiler and tools
#
# Runs on Debian 12 on x86-64, as any user; what is there already is kept. Needs g++ 12, cmake, ninja,
# nasm, pkg-config, dpkg-dev, python3-venv, and PyPI for meson; for aarch64 g++-aarch64-linux-gnu too.
# MIRROR names a mirror of Debian's archive.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mkdir -p "${1:?OUT: the folder to make}"
out=$(cd "$1" && pwd)
mirror=${MIRROR:-http://deb.debian.org/debian}
sysroot=$out/sysroot prefix=$out/prefix
machine=${2:-x86_64}
case $machine in
  x86_64) architecture=amd64 cross='' ;;
  aarch64) architecture=arm64 cross=aarch64-linux-gnu- ;;
  *)
    printf 'libraries: %s: for x86_64 or aarch64 alone\n' "$machine" >&2
    exit 2
    ;;
esac
triple=$machine-linux-gnu
cc=${CC:-${cross}gcc} cxx=${CXX:-${cross}g++} ar=${cross}ar
readonly httplib_options='-DCPPHTTPLIB_OPENSSL_SUPPORT -DCPPHTTPLIB_ZLIB_SUPPORT'

say() { printf 'libraries: %s\n' "$*" >&2; }

# Of the sources, the file in Debian's archive and its SHA-256 there. Debian 12's versions; Recast is sid's,
# which has the upstream code of 1.6.0.
readonly sources='
fmt       f/fmtlib/fmtlib_9.1.0+ds1.orig.tar.gz                          84ce1c2d0be3a9863935137969dcec6970125caac032f82474640bfc81463583
simdjson  s/simdjson/simdjson_3.0.1.orig.tar.gz                          156b1bc5eb0561b2bd166b46d191fd3d95a3e709cc63761477d3b7aec2b6e9ed
highway   h/highway/highway_1.0.3.orig.tar.gz                            566fc77315878473d9a6bd815f7de78c73734acdcb745c3dde8579560ac5440e
embree    e/embree/embree_3.13.5+dfsg.orig.tar.xz                        1b7c5b6144230ad81b92ece884a2017fbbb433bf5416a6fca9257e0109501c63
tinygltf  t/tinygltf/tinygltf_2.7.0+dfsg.orig.tar.xz                     d55bdecdc258be72041da3d7f5c8fd9faa0a93ad6cb42ff6893c82be713626d2
recast    r/recastnavigation/recastnavigation_1.6.0+dfsg.orig.tar.gz     d2f4a25e6e21d72f0cea4dd45152c790ffb312d7675582126602242102bdfec7
turbojpeg libj/libjpeg-turbo/libjpeg-turbo_2.1.5.orig.tar.gz             254f3642b04e309fee775123133c6464181addc150499561020312ec61c1bf7c
libzip    libz/libzip/libzip_1.7.3.orig.tar.xz                           a60473ffdb7b4260c08bfa19c2ccea0438edac11193c3afbbb1f17fbcf6c6132
spng      libs/libspng/libspng_0.7.3.orig.tar.gz                         a50cadbe808ffda1a7fab17d145f52a23b163f34b3eb3696c7ecb5a52340fc1d
epoxy     libe/libepoxy/libepoxy_1.5.10.orig.tar.gz                      a7ced37f4102b745ac86d6a70a9da399cc139ff168ba6b8002b4d8d43c900c15
httplib   c/cpp-httplib/cpp-httplib_0.11.4+ds.orig.tar.xz                8b1a5df569003b6a4f24c68489bbda5c64aec94697bdc9ebba5d79408b2ae7eb
'

# --- the sysroot ----------------------------------------------------------------------------------

# A private state of apt: neither this machine's sources nor its packages are touched.
apt_private() {
  local tool=$1 apt=$out/apt
  shift
  "$tool" -qq -o Dir::Etc::SourceList="$apt/sources.list" -o Dir::Etc::SourceParts=/dev/null \
    -o Dir::State="$apt/state" -o Dir::Cache="$apt/cache" -o Dir::State::status="$apt/status" \
    -o APT::Sandbox::User="$(id -un)" -o APT::Architecture="$architecture" \
    -o APT::Architectures="$architecture" -o Acquire::Retries=3 "$@"
}

make_sysroot() {
  local apt=$out/apt key=/usr/share/keyrings/debian-archive-keyring.gpg package
  [[ ! -e $sysroot/complete ]] || return 0
  say "C library of Debian 11, and packages of Debian 12"
  mkdir -p "$apt"/{state/lists/partial,cache/archives/partial,packages} "$sysroot"
  : >"$apt/status"
  printf 'deb [signed-by=%s] %s\n' \
    "$key" "$mirror bullseye main" "$key" "$mirror bookworm main" \
    "$key" "${mirror%/debian}/debian-security bookworm-security main" >"$apt/sources.list"
  apt_private apt-get update
  (cd "$apt/packages" && rm -f ./*.deb &&
    apt_private apt-get download libc6/bullseye libc6-dev/bullseye libgcc-s1/bullseye \
      linux-libc-dev/bullseye zlib1g-dev libzstd-dev libsqlite3-dev libsqlitecpp-dev libssl-dev \
      libxxhash-dev libutf8proc-dev nlohmann-json3-dev libcli11-dev libnanoflann-dev libstb-dev \
      libhdf5-dev libegl-dev libgl-dev)
  for package in "$apt/packages"/*.deb; do dpkg-deb -x "$package" "$sysroot"; done
  # Links to /lib/... mean the C library's own.
  find "$sysroot" -lname '/*' -printf '%p %l\n' | while read -r package target; do
    ln -sfn "$sysroot$target" "$package"
  done
  # Of the libraries, only the archives are to be found; the C library is the exception.
  find "$sysroot/usr/lib/$triple" -maxdepth 1 -regextype egrep -name '*.so' \
    -regex '.*/lib(hdf5.*|z|zstd|sqlite3|SQLiteCpp|ssl|crypto|turbojpeg|jpeg|xxhash|utf8proc|EGL|GL)\.so' -delete
  touch "$sysroot/complete"
}

write_toolchain() {
  mkdir -p "$prefix/lib/pkgconfig"
  "$cc" --sysroot="$sysroot" -O2 -fPIC -c "$here/old_glibc.c" -o "$prefix/lib/old_glibc.o"
  cat >"$out/toolchain.cmake" <<CMAKE
# Made by packaging/libraries.sh.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR $machine)
set(CMAKE_C_COMPILER $cc)
set(CMAKE_CXX_COMPILER $cxx)
set(CMAKE_LIBRARY_ARCHITECTURE $triple)
set(CMAKE_SYSROOT $sysroot)
set(CMAKE_FIND_ROOT_PATH $prefix $sysroot)
set(CMAKE_PREFIX_PATH $prefix)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_C_FLAGS_INIT "-ffunction-sections -fdata-sections")
set(CMAKE_CXX_FLAGS_INIT "-ffunction-sections -fdata-sections")
# What comes from archives is nobody else's: a process may have another HDF5, OpenSSL or libstdc++.
# -B: else gcc starts with this machine's crt1.o and libc.so, sysroot or not.
set(en_link "-B$sysroot/usr/lib/$triple -L$sysroot/lib/$triple $prefix/lib/old_glibc.o -static-libstdc++ -Wl,--exclude-libs,ALL -Wl,--gc-sections -Wl,--as-needed")
set(CMAKE_EXE_LINKER_FLAGS_INIT "\${en_link}")
set(CMAKE_SHARED_LINKER_FLAGS_INIT "\${en_link}")
set(CMAKE_MODULE_LINKER_FLAGS_INIT "\${en_link}")
set(CMAKE_CXX_STANDARD_LIBRARIES "-lpthread -ldl -lm")
set(ENV{PKG_CONFIG_LIBDIR} $prefix/lib/pkgconfig)
set(ENV{PKG_CONFIG_PATH} "")
set(ENV{PKG_CONFIG_SYSROOT_DIR} "")
CMAKE
}

# --- libraries from source ------------------------------------------------------------------------

unpack() {  # unpack NAME: its source in OUT/src/NAME
  local name=$1 file sum archive
  read -r _ file sum < <(awk -v name="$name" '$1 == name' <<<"$sources")
  archive=$out/src/${file##*/}
  mkdir -p "$out/src/$name"
  [[ -e $archive ]] || curl -fsSL --retry 3 -o "$archive" "$mirror/pool/main/${file//+/%2b}"
  sha256sum -c --quiet - <<<"$sum  $archive"
  tar -C "$out/src/$name" --strip-components=1 -xf "$archive"
}

# with_cmake NAME ARGS...
with_cmake() {
  local name=$1 build=$out/build/$1
  shift
  cmake -S "$out/src/$name" -B "$build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$out/toolchain.cmake" \
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_INSTALL_LIBDIR=lib \
    -DCMAKE_INSTALL_INCLUDEDIR=include -DBUILD_SHARED_LIBS=OFF -Wno-dev "$@"
  cmake --build "$build" --target install
}

# cmake_config NAME TARGET ARCHIVE: what Debian's package brings for CMake, and the source does not.
cmake_config() {
  mkdir -p "$prefix/lib/cmake/$1"
  cat >"$prefix/lib/cmake/$1/$1Config.cmake" <<CMAKE
add_library($2 STATIC IMPORTED)
set_target_properties($2 PROPERTIES
  IMPORTED_LOCATION $prefix/lib/$3 INTERFACE_INCLUDE_DIRECTORIES $prefix/include)
CMAKE
}

build_fmt() { with_cmake fmt -DFMT_TEST=OFF -DFMT_DOC=OFF; }
build_simdjson() { with_cmake simdjson; }
build_highway() {
  with_cmake highway -DBUILD_TESTING=OFF -DHWY_ENABLE_EXAMPLES=OFF -DHWY_ENABLE_CONTRIB=OFF \
    -DHWY_ENABLE_TESTS=OFF
  cmake_config hwy hwy::hwy libhwy.a
}
build_embree() {  # triangles alone, on its own threads: 4 MB in place of 40
  touch "$out/src/embree/readme.pdf"  # Debian's source is without it, and it is installed
  local kernels=$out/src/embree/kernels
  # One set beside the oldest: AVX2. Embree has trees of eight, which it wants there, come with AVX.
  # shellcheck disable=SC2016  # CMake's variables
  sed -i 's/${ISA} EQUAL ${\(ISA_LOWEST_AVX\|AVX\)})/${ISA} EQUAL ${AVX2})/' "$kernels/CMakeLists.txt"
  sed -i -e 's/(features & AVX) == AVX) intersector = avx::/(features \& AVX2) == AVX2) intersector = avx2::/' \
    -e 's/defined(EMBREE_TARGET_AVX) ||/defined(EMBREE_TARGET_AVX2) ||/' "$kernels/common/isa.h"
  sed -i 's/hasISA(AVX) &&/hasISA(AVX2) \&\&/' "$kernels/common/state.h"
  # Of what is switched off below, it compiles these even so.
  sed -i -E '/(curve_intersector_virtual_|scene_(user_geometry|instance|quad_mesh|curves|line_segments|grid_mesh|points)|bvh_builder_hair)/d' \
    "$kernels/CMakeLists.txt"
  local sets='-DEMBREE_ISA_SSE2=ON -DEMBREE_ISA_SSE42=OFF -DEMBREE_ISA_AVX=OFF -DEMBREE_ISA_AVX2=ON -DEMBREE_ISA_AVX512=OFF'
  [[ $machine == x86_64 ]] || sets='-DEMBREE_ARM=ON -DEMBREE_ISA_NEON=ON -DEMBREE_ISA_NEON2X=OFF -DEMBREE_IGNORE_CMAKE_CXX_FLAGS=OFF -DCMAKE_CXX_FLAGS=-flax-vector-conversions'
  # shellcheck disable=SC2086  # several words
  with_cmake embree -DEMBREE_STATIC_LIB=ON -DEMBREE_TUTORIALS=OFF -DEMBREE_ISPC_SUPPORT=OFF \
    -DEMBREE_TASKING_SYSTEM=INTERNAL -DEMBREE_MAX_ISA=NONE $sets \
    -DEMBREE_RAY_MASK=ON -DEMBREE_GEOMETRY_QUAD=OFF -DEMBREE_GEOMETRY_CURVE=OFF \
    -DEMBREE_GEOMETRY_SUBDIVISION=OFF -DEMBREE_GEOMETRY_USER=OFF -DEMBREE_GEOMETRY_INSTANCE=OFF \
    -DEMBREE_GEOMETRY_GRID=OFF -DEMBREE_GEOMETRY_POINT=OFF
}
build_tinygltf() {  # Debian's source is without the two libraries that it brings
  ln -sf "$sysroot"/usr/include/nlohmann/json.hpp "$sysroot"/usr/include/stb/stb_image*.h "$out/src/tinygltf/"
  with_cmake tinygltf -DTINYGLTF_BUILD_LOADER_EXAMPLE=OFF -DTINYGLTF_INSTALL=ON \
    -DTINYGLTF_HEADER_ONLY=OFF
  cmake_config TinyGLTF TinyGLTF::TinyGLTF libtinygltf.a
}
build_recast() {
  with_cmake recast -DRECASTNAVIGATION_DEMO=OFF -DRECASTNAVIGATION_TESTS=OFF \
    -DRECASTNAVIGATION_EXAMPLES=OFF
}
build_turbojpeg() {  # Debian's archive is for programs: its thread-local variable fits no module
  with_cmake turbojpeg -DENABLE_SHARED=OFF -DWITH_JAVA=OFF -DREQUIRE_SIMD=ON \
    -DCMAKE_INSTALL_LIBDIR="$prefix/lib" -DCMAKE_INSTALL_INCLUDEDIR="$prefix/include"  # it takes names for paths
}
build_libzip() {
  with_cmake libzip -DENABLE_COMMONCRYPTO=OFF -DENABLE_GNUTLS=OFF -DENABLE_MBEDTLS=OFF \
    -DENABLE_OPENSSL=OFF -DENABLE_BZIP2=OFF -DENABLE_LZMA=OFF -DBUILD_TOOLS=OFF \
    -DBUILD_REGRESS=OFF -DBUILD_EXAMPLES=OFF -DBUILD_DOC=OFF
}
build_spng() {  # its CMake file cannot do without the shared library
  "$cc" --sysroot="$sysroot" -O3 -fPIC -ffunction-sections -fdata-sections -DSPNG_STATIC \
    -c "$out/src/spng/spng/spng.c" -o "$out/build/spng.o"
  "$ar" rcs "$prefix/lib/libspng_static.a" "$out/build/spng.o"
  install -m 644 "$out/src/spng/spng/spng.h" "$prefix/include/"
}
build_epoxy() {  # opens libGL and libEGL when they are called
  local tools=$out/tools
  [[ -x $tools/bin/meson ]] || { python3 -m venv "$tools" && "$tools/bin/pip" install -q 'meson==1.6.*'; }
  # A cross build always: its flags are then the sysroot's, whatever machine this is.
  printf "[binaries]\nc = '%s'\nar = '%s'\npkg-config = 'pkg-config'\n[built-in options]\nc_args = ['--sysroot=%s', '-fPIC']
c_link_args = ['--sysroot=%s']\n[properties]\npkg_config_libdir = '%s'\n[host_machine]\nsystem = 'linux'\ncpu_family = '%s'\ncpu = '%s'\nendian = 'little'\n" \
    "$cc" "$ar" "$sysroot" "$sysroot" "$prefix/lib/pkgconfig" "$machine" "$machine" >"$out/meson.cross"
  "$tools/bin/meson" setup --wipe "$out/build/epoxy" "$out/src/epoxy" --prefix "$prefix" --libdir lib \
    --cross-file "$out/meson.cross" --buildtype release -Ddefault_library=static -Dglx=no -Dx11=false -Dtests=false
  "$tools/bin/meson" install -C "$out/build/epoxy"
}
build_httplib() {  # compiled once, as Debian does, and not in each source that includes it
  local split=$out/build/httplib
  mkdir -p "$split"
  python3 "$out/src/httplib/split.py" -o "$split"
  # shellcheck disable=SC2086  # several words
  "$cxx" --sysroot="$sysroot" $httplib_options -std=c++17 -O2 -fPIC -ffunction-sections \
    -fdata-sections -I"$split" -c "$split/httplib.cc" -o "$split/httplib.o"
  "$ar" rcs "$prefix/lib/libcpp-httplib.a" "$split/httplib.o"
  install -m 644 "$split/httplib.h" "$prefix/include/"
}

build_all() {
  local name
  mkdir -p "$out/done" "$prefix/include"
  while read -r name _; do
    [[ -n $name && ! -e $out/done/$name ]] || continue
    say "$name"
    unpack "$name"
    build_"$name" >"$out/$name.log" 2>&1 </dev/null || {
      tail -n 30 "$out/$name.log" >&2
      say "$name could not be built (all of its output: $out/$name.log)"
      exit 1
    }
    touch "$out/done/$name"
  done <<<"$sources"
}

# pkg_config NAME VERSION CFLAGS LIBS: those of the system name shared libraries, and leave out what these need.
pkg_config() {
  printf 'Name: %s\nDescription: static, for wheels\nVersion: %s\nCflags: %s\nLibs: %s\n' \
    "$1" "$2" "$3" "$4" >"$prefix/lib/pkgconfig/$1.pc"
}

write_pkg_config() {
  local system=-L$sysroot/usr/lib/$triple own=-L$prefix/lib
  # By -l: CMake takes a file's name for an option, and puts it before what needs it.
  pkg_config libturbojpeg 2.1.5 "-I$prefix/include" "$own -lturbojpeg"
  pkg_config libjpeg 2.1.5 "-I$prefix/include" "$own -lturbojpeg -ljpeg"
  pkg_config libzstd 1.5.4 '' "$system -lzstd"
  pkg_config libzip 1.7.3 "-I$prefix/include" "$own $system -lzip -lz"
  pkg_config spng 0.7.3 "-I$prefix/include -DSPNG_STATIC" "$own $system -lspng_static -lz -lm"
  pkg_config libxxhash 0.8.1 '' "$system -lxxhash"
  pkg_config libutf8proc 2.8.0 '-DUTF8PROC_STATIC' "$system -lutf8proc"
  # Nothing without libtorch reads HDF5: the headers will do, and a program that links it does not link.
  pkg_config hdf5 1.10.8 "-I$sysroot/usr/include/hdf5/serial" ''
  pkg_config egl 1.5 '' ''
  pkg_config openssl 3.0 '' "$system -lssl -lcrypto"
  pkg_config cpp-httplib 0.11.4 "-I$prefix/include $httplib_options" \
    "$own $system -lcpp-httplib -lssl -lcrypto -lz"
}

# The licences of all that is linked in, one after the other.
write_notices() {
  local file
  {
    printf 'What these wheels have linked in, and its licences.\n'
    for file in "$sysroot"/usr/share/doc/*/copyright "$out"/src/*/{LICENSE,LICENSE.txt,License.txt,COPYING}; do
      [[ -e $file && ! -L $file ]] || continue
      printf '\n===== %s\n\n' "$(basename "$(dirname "$file")")"
      cat "$file"
    done
  } >"$out/THIRD_PARTY.txt"
}

make_sysroot
write_toolchain
write_pkg_config
build_all
write_pkg_config  # after those that the libraries install
write_notices
say "done: $out"
