# Compiler flags of every target of ours: link to enfilade_compile, privately.
add_library(enfilade_compile INTERFACE)

# Every read of a JSON value names its type: an implicit conversion that gcc 12 takes is ambiguous to gcc 14.
target_compile_definitions(enfilade_compile INTERFACE JSON_USE_IMPLICIT_CONVERSIONS=0)

if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  # The simulator reproduces recorded single-precision results bit for bit, so a*b+c must not
  # become one rounding on machines that could fuse it.
  target_compile_options(enfilade_compile INTERFACE -ffp-contract=off)
  # Not for users: they cannot mend what a newer compiler warns of, and looking for it takes about a
  # tenth of the compiler's time.
  if(EN_DEVELOPER_MODE)
    target_compile_options(enfilade_compile INTERFACE
      -Wall -Wextra -Wshadow -Wconversion -Wnon-virtual-dtor -Wold-style-cast -Wundef -Werror)
  endif()
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # False alarms of optimised builds: gcc 12 sees overlapping copies in "literal" + std::string
  # (GCC bug 105329) and reads from a std::optional that was just found not to be empty.
  target_compile_options(enfilade_compile INTERFACE -Wno-restrict -Wno-maybe-uninitialized)
endif()

if(EN_FAST_LINKER)
  include(CheckLinkerFlag)
  foreach(linker mold lld)
    check_linker_flag(CXX -fuse-ld=${linker} EN_HAS_${linker})
    if(EN_HAS_${linker})
      add_link_options(-fuse-ld=${linker})
      break()
    endif()
  endforeach()
endif()

if(EN_SANITIZE)
  # Every target of the build, tests' libraries included, has to agree on this.
  add_compile_options(-fsanitize=${EN_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${EN_SANITIZE})
endif()

# What a Python needs in its environment to import modules of this build, a list of NAME=VALUE. It is not
# instrumented, so that it has to load the sanitizer's library first; and libstdc++, without which that
# library can't follow exceptions. What leaks at its end is the interpreter's own.
set(EN_PYTHON_ENVIRONMENT "")
set(EN_TIMEOUT_FACTOR 1)  # of tests' time limits
if(CMAKE_CROSSCOMPILING_EMULATOR)
  set(EN_TIMEOUT_FACTOR 10)
endif()
if(EN_SANITIZE)
  set(EN_TIMEOUT_FACTOR 4)
  if(EN_SANITIZE MATCHES "thread")
    set(preloaded tsan stdc++)
    list(APPEND EN_PYTHON_ENVIRONMENT
      "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/python/tests/tsan_suppressions.txt")
  else()
    set(preloaded asan stdc++)
    list(APPEND EN_PYTHON_ENVIRONMENT "ASAN_OPTIONS=detect_leaks=0")
  endif()
  list(TRANSFORM preloaded REPLACE "(.+)" "lib\\1.so")
  set(files "")
  foreach(library IN LISTS preloaded)
    execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=${library}
      OUTPUT_VARIABLE file OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    string(APPEND files "${file} ")
  endforeach()
  list(APPEND EN_PYTHON_ENVIRONMENT "LD_PRELOAD=${files}")
endif()

if(EN_BUILD_FUZZERS)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "EN_BUILD_FUZZERS needs clang (libFuzzer); this compiler is "
      "${CMAKE_CXX_COMPILER_ID}. Use: cmake --preset fuzz")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all)
  add_link_options(-fsanitize=address,undefined)
endif()
