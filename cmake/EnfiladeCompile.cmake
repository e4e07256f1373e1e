# Compiler flags of every target of ours: link to enfilade_compile, privately.
add_library(enfilade_compile INTERFACE)

if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  # The simulator reproduces recorded single-precision results bit for bit, so a*b+c must not
  # become one rounding on machines that could fuse it.
  target_compile_options(enfilade_compile INTERFACE -ffp-contract=off)
  target_compile_options(enfilade_compile INTERFACE
    -Wall -Wextra -Wshadow -Wconversion -Wnon-virtual-dtor -Wold-style-cast -Wundef
    $<$<BOOL:${EN_DEVELOPER_MODE}>:-Werror>)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # False alarms of optimised builds: gcc 12 sees overlapping copies in "literal" + std::string
  # (GCC bug 105329) and reads from a std::optional that was just found not to be empty.
  target_compile_options(enfilade_compile INTERFACE -Wno-restrict -Wno-maybe-uninitialized)
endif()

if(EN_SANITIZE)
  # Every target of the build, tests' libraries included, has to agree on this.
  add_compile_options(-fsanitize=${EN_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${EN_SANITIZE})
endif()
if(EN_BUILD_FUZZERS)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "EN_BUILD_FUZZERS needs clang (libFuzzer); this compiler is "
      "${CMAKE_CXX_COMPILER_ID}. Use: cmake --preset fuzz")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all)
  add_link_options(-fsanitize=address,undefined)
endif()
