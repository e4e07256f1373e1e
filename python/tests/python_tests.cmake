# The tests of the Python package, as ctest runs them.
set(environment "PYTHONPATH=${PROJECT_BINARY_DIR}/python" "PYTHONDONTWRITEBYTECODE=1")
if(EN_BUILD_APPS AND EN_WITH_TORCH)  # for feature files that it and the package both write
  list(APPEND environment "ENFILADE_PROGRAM=$<TARGET_FILE:enfilade>")
endif()
set(pytest -m pytest -q -rs -p no:cacheprovider)
set(chosen "")

if(EN_SANITIZE)
  # The interpreter is not instrumented, so that it has to load the sanitizer's library first; and libstdc++,
  # without which that library can't follow exceptions. What is left at the end is the interpreter's own.
  if(EN_SANITIZE MATCHES "thread")
    set(library tsan)
    set(chosen -k "thread and not torch")
    list(APPEND environment
      "TSAN_OPTIONS=suppressions=${CMAKE_CURRENT_LIST_DIR}/tsan_suppressions.txt")
  else()
    set(library asan)
    # Freed memory is kept for a while, so that none is flat; other libraries' examples take too long.
    set(chosen -k "not hundred_thousand and not test_examples")
    list(APPEND environment "ASAN_OPTIONS=detect_leaks=0")
  endif()
  set(preload "")
  foreach(name ${library} stdc++)
    execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=lib${name}.so
      OUTPUT_VARIABLE file OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    string(APPEND preload "${file} ")
  endforeach()
  list(APPEND environment "LD_PRELOAD=${preload}")
endif()

add_test(NAME python.tests
  COMMAND ${Python_EXECUTABLE} ${pytest} ${chosen} ${CMAKE_CURRENT_LIST_DIR})
set_tests_properties(python.tests PROPERTIES TIMEOUT 1800 LABELS slow ENVIRONMENT "${environment}")

set(EN_TORCH_PYTHON "" CACHE FILEPATH
  "Another Python of the same version, with PyTorch: python.torch tests what needs it")
if(EN_TORCH_PYTHON AND NOT EN_SANITIZE)
  add_test(NAME python.torch COMMAND ${EN_TORCH_PYTHON} ${pytest}
    -k "torch or (test_examples and (extract or imitation or rl))" ${CMAKE_CURRENT_LIST_DIR})
  set_tests_properties(python.torch PROPERTIES TIMEOUT 1800 LABELS slow ENVIRONMENT "${environment}")
endif()
