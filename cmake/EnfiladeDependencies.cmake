# What Enfilade is built on: found on the system, never downloaded. docs/dependencies.md says why each.

# Fails with the package to install instead of CMake's "could not find a configuration file".
macro(enfilade_require name package)
  find_package(${name} ${ARGN} QUIET)
  if(NOT ${name}_FOUND)
    message(FATAL_ERROR "Enfilade needs ${name}, which is not on this machine. "
      "On Debian and Ubuntu: apt-get install ${package} (or let ./enfilade.sh build do it).")
  endif()
endmacro()

# The same for libraries that come with a pkg-config file only; makes the target PkgConfig::<name>.
find_package(PkgConfig REQUIRED)
macro(enfilade_require_pc name package)
  pkg_check_modules(${name} IMPORTED_TARGET ${name})
  if(NOT ${name}_FOUND)
    message(FATAL_ERROR "Enfilade needs ${name}, which is not on this machine. "
      "On Debian and Ubuntu: apt-get install ${package} (or let ./enfilade.sh build do it).")
  endif()
endmacro()

find_package(Threads REQUIRED)
enfilade_require(fmt libfmt-dev)
enfilade_require(simdjson libsimdjson-dev)
enfilade_require(nlohmann_json nlohmann-json3-dev)
enfilade_require(nanoflann libnanoflann-dev)
if(EN_WITH_TBB)
  enfilade_require(TBB libtbb-dev)
endif()
enfilade_require(hwy libhwy-dev)
# Registers whose width is not known when compiling (of ARM's SVE and of RISC-V) cannot be members of a struct,
# nor be put together from halves, as our kernels do: ARM with SVE runs what is compiled for NEON.
target_compile_definitions(hwy::hwy INTERFACE
  "HWY_DISABLED_TARGETS=(HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128|HWY_RVV)")
enfilade_require(embree libembree-dev)
enfilade_require(TinyGLTF libtinygltf-dev)
list(APPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})
enfilade_require(Recast librecast-dev)
# By pkg-config, as Debian's CMake files of libzip and libjpeg-turbo want files of other packages.
enfilade_require_pc(libturbojpeg libturbojpeg0-dev)
enfilade_require_pc(libzstd libzstd-dev)
enfilade_require_pc(libzip libzip-dev)
enfilade_require_pc(spng libspng-dev)
enfilade_require_pc(libxxhash libxxhash-dev)
enfilade_require_pc(hdf5 libhdf5-dev)
if(EN_WITH_GL)
  enfilade_require_pc(epoxy libepoxy-dev)
  enfilade_require_pc(egl libegl-dev)
endif()
set(EN_D3_FILE "")
if(EN_WITH_D3)
  # Becomes part of the program: nobody who runs it needs the file.
  find_file(D3_SCRIPT d3.min.js PATHS /usr/share/nodejs/d3/dist /usr/share/javascript/d3
    DOC "d3.min.js, version 5 or newer, in one file")
  if(NOT D3_SCRIPT)
    message(FATAL_ERROR "Enfilade needs D3, which is not on this machine. On Debian and Ubuntu: "
      "apt-get install --no-install-recommends node-d3 (or let ./enfilade.sh build do it). "
      "Elsewhere: -DD3_SCRIPT=FILE names a d3.min.js. -DEN_WITH_D3=OFF does without the report.")
  endif()
  set(EN_D3_FILE ${D3_SCRIPT})
endif()
if(EN_WITH_TORCH)
  enfilade_require(Torch "libtorch-dev libopenblas0-pthread")
endif()
if(EN_WITH_WEB)
  enfilade_require(SQLiteCpp "libsqlitecpp-dev libsqlite3-dev")
  enfilade_require(ZLIB zlib1g-dev)
  pkg_check_modules(httplib IMPORTED_TARGET cpp-httplib)
  enfilade_require_pc(openssl libssl-dev)
  if(NOT httplib_FOUND)
    message(FATAL_ERROR "Enfilade needs cpp-httplib, which is not on this machine. On Debian and "
      "Ubuntu: apt-get install libcpp-httplib-dev. -DEN_WITH_WEB=OFF does without the server.")
  endif()
endif()
if(EN_BUILD_APPS)
  enfilade_require(CLI11 libcli11-dev)
  enfilade_require(ZLIB zlib1g-dev)
endif()
if(EN_BUILD_TESTS)
  enfilade_require(GTest "libgtest-dev libgmock-dev")
  include(GoogleTest)
endif()
if(EN_BUILD_BENCH)
  enfilade_require(benchmark libbenchmark-dev)
endif()
