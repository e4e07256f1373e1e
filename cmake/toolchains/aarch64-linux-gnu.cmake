# Cross-compiling for 64-bit ARM with the distribution's compiler. EN_SYSROOT is a folder with the libraries of
# an ARM machine, as `./enfilade.sh test --preset aarch64` makes one from Debian's packages. Programs that
# the build has to run, tests above all, run in qemu-user.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)

list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES EN_SYSROOT)
if(NOT EXISTS "${EN_SYSROOT}/usr/lib/aarch64-linux-gnu")
  message(FATAL_ERROR "EN_SYSROOT is '${EN_SYSROOT}', which has no usr/lib/aarch64-linux-gnu. "
    "./enfilade.sh build --preset aarch64 makes one and names it here.")
endif()
set(CMAKE_SYSROOT ${EN_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${EN_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR}
  ${EN_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${EN_SYSROOT}/usr/share/pkgconfig)

if(NOT CMAKE_HOST_SYSTEM_PROCESSOR STREQUAL CMAKE_SYSTEM_PROCESSOR)
  find_program(EN_QEMU NAMES qemu-aarch64 qemu-aarch64-static)
  if(EN_QEMU)
    set(CMAKE_CROSSCOMPILING_EMULATOR ${EN_QEMU} -L ${EN_SYSROOT})
  endif()
endif()
