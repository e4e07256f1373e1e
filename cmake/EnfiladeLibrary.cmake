# Options of code that takes no time when it runs, such as reading options or writing pages. The compiler
# takes a tenth to a third less than with -O3.
set(EN_COLD_OPTIONS $<$<CONFIG:Release,RelWithDebInfo>:-O1>)
set(EN_HOT_OPTIONS $<$<CONFIG:Release>:-O3> $<$<CONFIG:RelWithDebInfo>:-O2>)

# Headers that most sources include, parsed once for all libraries and once for all tests: a build for users takes
# a seventh less. The preset dev and the linter have none, so that each source includes what it uses. gcc takes a
# precompiled header where macros that appear in it, and options such as -fPIC, are the same; of another level of -O
# too, but gcc 12 may crash then.
if(EN_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
  set(EN_SHARED_HEADERS ON)
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/shared_headers.cpp CONTENT "")
  set(EN_STANDARD_HEADERS <algorithm> <array> <cmath> <filesystem> <functional> <map> <memory> <mutex> <numeric> <optional>
    <ranges> <set> <span> <string> <string_view> <unordered_map> <utility> <variant> <vector>
    <fmt/format.h> <fmt/ranges.h>)
  set(plain_headers "")
  set(json_headers <nlohmann/json.hpp> <simdjson.h>)
  set(cold_headers ${json_headers})
  foreach(kind IN ITEMS plain json cold)
    add_library(enfilade_${kind}_headers OBJECT EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/shared_headers.cpp)
    set_target_properties(enfilade_${kind}_headers PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_compile_features(enfilade_${kind}_headers PRIVATE cxx_std_20)
    target_link_libraries(enfilade_${kind}_headers PRIVATE enfilade_compile fmt::fmt)
    if(kind STREQUAL "cold")
      target_compile_options(enfilade_${kind}_headers PRIVATE ${EN_COLD_OPTIONS})
    endif()
    if(NOT kind STREQUAL "plain")
      target_link_libraries(enfilade_${kind}_headers PRIVATE nlohmann_json::nlohmann_json simdjson::simdjson)
    endif()
    target_precompile_headers(enfilade_${kind}_headers PRIVATE ${EN_STANDARD_HEADERS} ${${kind}_headers})
  endforeach()
endif()

# What is checked is the library: GoogleTest's macros take three times as long to compile with -O1 and sanitizers, and
# half as long again without them.
set(EN_TEST_OPTIONS $<$<CONFIG:Release,RelWithDebInfo>:-O0>)
if(EN_SHARED_HEADERS AND EN_BUILD_TESTS)
  add_library(enfilade_test_headers OBJECT EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/shared_headers.cpp)
  target_compile_features(enfilade_test_headers PRIVATE cxx_std_20)
  target_link_libraries(enfilade_test_headers PRIVATE enfilade_compile GTest::gmock GTest::gtest_main fmt::fmt)
  target_compile_options(enfilade_test_headers PRIVATE ${EN_TEST_OPTIONS})
  target_precompile_headers(enfilade_test_headers PRIVATE ${EN_STANDARD_HEADERS} <gmock/gmock.h> <gtest/gtest.h>)
endif()
if(EN_BUILD_TESTS)
  add_library(enfilade_until OBJECT ${PROJECT_SOURCE_DIR}/tests/support/until.cpp)
  target_compile_features(enfilade_until PRIVATE cxx_std_20)
  target_link_libraries(enfilade_until PRIVATE enfilade_compile GTest::gtest)
endif()

# One folder of enfilade/ = one static library = one target enfilade::<name> = one test program.
#
#   enfilade_library(graph
#     SOURCES nav_graph.cpp ...
#     TESTS nav_graph_test.cpp ...
#     DEPENDS scan                  folders whose headers ours include (public)
#     PRIVATE nanoflann::nanoflann  third parties, seen by our sources only
#     ALONE nav_graph.cpp           never compiled in one go with others (EN_UNITY): its local names
#                                   are theirs too
#     HEADERS <ATen/ATen.h> ...     precompiled for it alone, in place of the shared ones
#     COLD                          nothing here takes long when it runs: -O1, which compiles faster
#     HOT kernels.cpp ...           of a COLD library: with its build type's options all the same
#     TEST_LIBRARIES enfilade::homes ...
#     WHOLE                         its test program is one test (enfilade_test)
function(enfilade_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "COLD;WHOLE" "" "SOURCES;TESTS;DEPENDS;PRIVATE;TEST_LIBRARIES;ALONE;HEADERS;HOT")
  set(target enfilade_${name})
  add_library(${target} STATIC ${arg_SOURCES})
  add_library(enfilade::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  enfilade_unity(${target} ALONE ${arg_ALONE})
  if(arg_COLD)
    target_compile_options(${target} PRIVATE ${EN_COLD_OPTIONS})
    set_source_files_properties(${arg_HOT} PROPERTIES COMPILE_OPTIONS "${EN_HOT_OPTIONS}"
      SKIP_PRECOMPILE_HEADERS ON)
  endif()
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include>)
  list(TRANSFORM arg_DEPENDS PREPEND enfilade::)
  target_link_libraries(${target} PUBLIC ${arg_DEPENDS}
    PRIVATE $<BUILD_INTERFACE:enfilade_compile> ${arg_PRIVATE})
  if(arg_HEADERS)
    target_precompile_headers(${target} PRIVATE ${arg_HEADERS})
    enfilade_quiet_headers(${target})
  elseif("simdjson::simdjson" IN_LIST arg_PRIVATE)
    if(arg_COLD)
      enfilade_shared_headers(${target} cold)
    else()
      enfilade_shared_headers(${target} json)
    endif()
  elseif(NOT arg_COLD)
    enfilade_shared_headers(${target} plain)
  endif()
  install(TARGETS ${target} EXPORT enfilade ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  set_property(GLOBAL APPEND PROPERTY ENFILADE_LIBRARIES enfilade::${name})
  # Headers in sub-folders, detail/ and rooms, are the library's own.
  file(GLOB headers CONFIGURE_DEPENDS *.h)
  install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/enfilade/${name})
  if(EN_BUILD_TESTS AND arg_TESTS)
    set(whole "")
    if(arg_WHOLE)
      set(whole WHOLE)
    endif()
    enfilade_test(${name}_test ${whole} SOURCES ${arg_TESTS} LIBRARIES ${target} ${arg_PRIVATE}
      ${arg_TEST_LIBRARIES})
  endif()
endfunction()

# Sources of TARGET are compiled several at a time where EN_UNITY is on, but for those that are ALONE.
function(enfilade_unity target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "ALONE")
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${EN_UNITY})
  set_source_files_properties(${arg_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  if(EN_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # With sources included in one another, gcc takes each for a header whose types could leak.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()

# Sources of TARGET begin with the shared headers of a KIND, plain, json, (-O1) cold or test, where there are any.
function(enfilade_shared_headers target kind)
  if(EN_SHARED_HEADERS)
    target_precompile_headers(${target} REUSE_FROM enfilade_${kind}_headers)
    # Some sources have options of their own, and parse them again.
    set_target_properties(${target} PROPERTIES PCH_WARN_INVALID OFF)
    enfilade_quiet_headers(${target})
  endif()
endfunction()

# gcc 12 does not know any more that precompiled headers are the system's, and warns of what it inlines.
function(enfilade_quiet_headers target)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    target_compile_options(${target} PRIVATE -Wno-stringop-overflow -Wno-array-bounds)
  endif()
endfunction()

# Has a build step make SOURCE out of text files, so that a library carries them in itself.
# TEXTS: NAME=FILE|FILE,NAME=FILE, constants of NAMESPACE that HEADER declares (embed_text.cmake).
# DEPENDS: the files. COMMENT: what the build says.
function(enfilade_embed_text source)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "HEADER;NAMESPACE;TEXTS;COMMENT" "DEPENDS")
  set(script ${PROJECT_SOURCE_DIR}/cmake/embed_text.cmake)
  add_custom_command(OUTPUT ${source}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${source} -DHEADER=${arg_HEADER}
      -DNAMESPACE=${arg_NAMESPACE} "-DTEXTS=${arg_TEXTS}" -P ${script}
    DEPENDS ${arg_DEPENDS} ${script}
    COMMENT ${arg_COMMENT}
    VERBATIM)
endfunction()

# A GoogleTest program whose tests ctest runs one by one. SLOW: they are left out of a quick run
# (`./enfilade.sh test --quick`), as are all tests with the label `slow`. WHOLE: the program is one test of ctest, as
# its tests share what takes longer than they do: homes, or loading libtorch (a second each).
function(enfilade_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "SLOW;WHOLE" "" "SOURCES;LIBRARIES;DEFINITIONS")
  add_executable(${name} ${arg_SOURCES})
  set(helpers ${arg_SOURCES})  # what is no test may have names that others call, and is compiled alone
  list(FILTER helpers EXCLUDE REGEX "_test\\.cpp$")
  enfilade_unity(${name} ALONE ${helpers})
  # Local names of a test are its own: `namespace EN_UNIT {` has no name where each source is compiled alone.
  set_target_properties(${name} PROPERTIES UNITY_BUILD_UNIQUE_ID EN_UNIT)
  if(NOT EN_UNITY)
    target_compile_definitions(${name} PRIVATE EN_UNIT=)
  endif()
  target_link_libraries(${name} PRIVATE ${arg_LIBRARIES} enfilade_compile GTest::gmock
    GTest::gtest_main fmt::fmt enfilade_until)
  target_compile_definitions(${name} PRIVATE EN_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    ${arg_DEFINITIONS})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/test)
  target_compile_options(${name} PRIVATE ${EN_TEST_OPTIONS})
  enfilade_shared_headers(${name} test)
  set(label "")
  set(seconds 300)
  if(arg_SLOW)
    # Begun first, as no core should wait for the last one.
    set(label LABELS slow COST 50 ENVIRONMENT ENFILADE_TEST_IS_SLOW=1)
    set(seconds 1200)  # two homes worth looking at take three minutes of two idle cores
  endif()
  if(arg_WHOLE)
    math(EXPR timeout "1800 * ${EN_TIMEOUT_FACTOR}")
    add_test(NAME ${name} COMMAND ${name})
    set_tests_properties(${name} PROPERTIES TIMEOUT ${timeout} COST 40 ${label}
      SKIP_REGULAR_EXPRESSION "\\[  SKIPPED \\] all")  # by tests/support/until.cpp
    return()
  endif()
  math(EXPR timeout "${seconds} * ${EN_TIMEOUT_FACTOR}")
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT ${timeout} ${label})
endfunction()

# A program in bin/: the command line, its tools, examples and benchmarks.
function(enfilade_program name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LIBRARIES")
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE ${arg_LIBRARIES} enfilade_compile fmt::fmt)
endfunction()
