# The tests of the Python package, as ctest runs them.
set(environment "PYTHONPATH=${PROJECT_BINARY_DIR}/python" "PYTHONDONTWRITEBYTECODE=1")
if(EN_BUILD_APPS AND EN_WITH_TORCH)  # for feature files that it and the package both write
  list(APPEND environment "ENFILADE_PROGRAM=$<TARGET_FILE:enfilade>")
endif()
if(EN_BUILD_APPS)
  list(APPEND environment "ENFILADE_COMMAND=$<TARGET_FILE:enfilade>")
endif()
if(TARGET bad_driver)
  list(APPEND environment "ENFILADE_BAD_DRIVER=$<TARGET_FILE:bad_driver>")
endif()
set(pytest -m pytest -q -rs -p no:cacheprovider)
set(chosen "")

if(EN_SANITIZE MATCHES "thread")
  set(chosen -k "thread and not torch")
elseif(EN_SANITIZE)
  # Freed memory is kept for a while, so that none is flat; other libraries' examples take too long.
  set(chosen -k "not hundred_thousand and not test_examples")
endif()
list(APPEND environment ${EN_PYTHON_ENVIRONMENT})

# Two, as one process would be busy when all other tests are done.
file(GLOB habitat_tests CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/test_*habitat*.py)
set(python_tests python.tests)
add_test(NAME python.tests
  COMMAND ${Python_EXECUTABLE} ${pytest} ${chosen} "--ignore-glob=${CMAKE_CURRENT_LIST_DIR}/*habitat*" ${CMAKE_CURRENT_LIST_DIR})
if(NOT EN_SANITIZE MATCHES "thread")  # none of them has threads
  list(APPEND python_tests python.habitat)
  add_test(NAME python.habitat COMMAND ${Python_EXECUTABLE} ${pytest} ${chosen} ${habitat_tests})
endif()
set_tests_properties(${python_tests} PROPERTIES TIMEOUT 3600 LABELS slow COST 300 ENVIRONMENT "${environment}")

set(EN_TORCH_PYTHON "" CACHE FILEPATH
  "Another Python of the same version, with PyTorch: python.torch tests what needs it")
if(EN_TORCH_PYTHON AND NOT EN_SANITIZE)
  add_test(NAME python.torch COMMAND ${EN_TORCH_PYTHON} ${pytest}
    -k "torch or (test_examples and (extract or imitation or rl))" ${CMAKE_CURRENT_LIST_DIR})
  set_tests_properties(python.torch PROPERTIES TIMEOUT 3600 LABELS slow COST 300 ENVIRONMENT "${environment}")
endif()
