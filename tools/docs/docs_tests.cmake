# Tests of the documentation: the site, the links, the tutorials. Included by tests/CMakeLists.txt.
set(EN_DOCS_PYTHON "" CACHE FILEPATH
  "A Python that has tools/docs/requirements.txt: docs.site builds the documentation with it")
find_program(PYTHON3_PROGRAM python3)
find_program(DOXYGEN_PROGRAM doxygen)

if(EN_DOCS_PYTHON AND DOXYGEN_PROGRAM)
  add_test(NAME docs.site
    COMMAND ${EN_DOCS_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/site.py -o ${PROJECT_BINARY_DIR}/docs --no-runs)
  set_tests_properties(docs.site PROPERTIES TIMEOUT 300)
  add_test(NAME docs.tools COMMAND ${EN_DOCS_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/tools_test.py)
else()
  add_test(NAME docs.site COMMAND ${CMAKE_COMMAND} -E echo
    "The documentation is not built: no doxygen, or EN_DOCS_PYTHON is not set (no PyPI)")
  set_tests_properties(docs.site PROPERTIES SKIP_REGULAR_EXPRESSION "documentation is not built")
endif()

if(PYTHON3_PROGRAM)
  add_test(NAME docs.links COMMAND ${PYTHON3_PROGRAM} -B ${CMAKE_CURRENT_LIST_DIR}/markdown_tree.py)
  add_test(NAME docs.prose COMMAND ${PYTHON3_PROGRAM} -B ${CMAKE_CURRENT_LIST_DIR}/prose.py)
  add_test(NAME docs.asvs COMMAND ${PYTHON3_PROGRAM} -B ${CMAKE_CURRENT_LIST_DIR}/asvs.py)
  add_test(NAME docs.threats COMMAND ${PYTHON3_PROGRAM} -B ${CMAKE_CURRENT_LIST_DIR}/threats.py)
  if(EN_BUILD_PYTHON)
    set(python ${Python_EXECUTABLE})
  else()
    set(python ${PYTHON3_PROGRAM})
  endif()
  file(GLOB pages CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/tutorials/*.md)
  foreach(page IN LISTS pages)
    get_filename_component(name ${page} NAME_WE)
    file(STRINGS ${page} commands REGEX "^```sh run")
    if(commands AND EN_BUILD_APPS)
      add_test(NAME tutorial.${name} COMMAND ${PYTHON3_PROGRAM} -B ${CMAKE_CURRENT_LIST_DIR}/tutorials.py
        ${page} --build ${PROJECT_BINARY_DIR} --python ${python}
        --python-environment ${EN_PYTHON_ENVIRONMENT})
      math(EXPR timeout "900 * ${EN_TIMEOUT_FACTOR}")
      set_tests_properties(tutorial.${name} PROPERTIES TIMEOUT ${timeout} SKIP_RETURN_CODE 77 LABELS slow)
    endif()
  endforeach()
endif()
