# libtorch as Debian and Ubuntu ship it, or the one inside a PyTorch that pip installed
# (-DCMAKE_PREFIX_PATH=.../site-packages/torch). Its own CMake files are not asked: those of a PyTorch for
# CUDA want the CUDA compiler, which nobody needs who has no kernel of his own.
set(Torch_PYTHON_DIR "")
set(Torch_PYTHON_VERSION "")
if(SKBUILD)  # pip: the PyTorch of the environment that it builds in, if it has one
  find_package(Python COMPONENTS Interpreter QUIET)
  execute_process(COMMAND ${Python_EXECUTABLE} -c
    "import importlib.metadata as m, importlib.util as u; print(*u.find_spec('torch').submodule_search_locations, m.version('torch'), sep=';')"
    OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(found)
    list(GET found 0 Torch_PYTHON_DIR)
    list(GET found -1 Torch_PYTHON_VERSION)
  endif()
endif()
find_path(Torch_INCLUDE_DIR ATen/ATen.h HINTS ${Torch_PYTHON_DIR}/include)
find_library(Torch_LIBRARY torch HINTS ${Torch_PYTHON_DIR}/lib)
find_library(Torch_CPU_LIBRARY torch_cpu HINTS ${Torch_PYTHON_DIR}/lib)
find_library(Torch_C10_LIBRARY c10 HINTS ${Torch_PYTHON_DIR}/lib)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Torch REQUIRED_VARS Torch_LIBRARY Torch_CPU_LIBRARY
  Torch_C10_LIBRARY Torch_INCLUDE_DIR)
if(Torch_FOUND AND NOT TARGET Torch::Torch)
  set(headers ${Torch_INCLUDE_DIR})
  if(NOT headers IN_LIST CMAKE_CXX_IMPLICIT_INCLUDE_DIRECTORIES)
    # Of a PyTorch, no more than these: its folder has an fmt and others of its own, not our versions.
    set(headers ${CMAKE_BINARY_DIR}/torch_headers)
    file(MAKE_DIRECTORY ${headers})
    foreach(folder IN ITEMS ATen c10 torch)
      file(CREATE_LINK ${Torch_INCLUDE_DIR}/${folder} ${headers}/${folder} SYMBOLIC)
    endforeach()
  endif()
  add_library(Torch::Torch INTERFACE IMPORTED)
  target_include_directories(Torch::Torch INTERFACE
    ${headers} ${headers}/torch/csrc/api/include)
  # Nothing calls into libtorch.so itself; it is what loads the part for CUDA, where there is one.
  target_link_libraries(Torch::Torch INTERFACE
    "-Wl,--push-state,--no-as-needed,${Torch_LIBRARY},--pop-state"
    ${Torch_CPU_LIBRARY} ${Torch_C10_LIBRARY})
  # Processes that train together, where libtorch has them and Gloo's headers are there (Debian:
  # libgloo-dev). Those of a PyTorch need the same ones: no more than names is taken from them.
  find_path(Gloo_INCLUDE_DIR gloo/context.h HINTS ${Torch_PYTHON_DIR}/include)
  mark_as_advanced(Gloo_INCLUDE_DIR)
  if(Gloo_INCLUDE_DIR AND EXISTS
      ${Torch_INCLUDE_DIR}/torch/csrc/distributed/c10d/ProcessGroupGloo.hpp)
    target_compile_definitions(Torch::Torch INTERFACE USE_DISTRIBUTED USE_C10D_GLOO EN_WITH_C10D)
    if(NOT Gloo_INCLUDE_DIR IN_LIST CMAKE_CXX_IMPLICIT_INCLUDE_DIRECTORIES)
      target_include_directories(Torch::Torch INTERFACE ${Gloo_INCLUDE_DIR})
    endif()
    include(TorchNccl)
  endif()
endif()
mark_as_advanced(Torch_INCLUDE_DIR Torch_LIBRARY Torch_CPU_LIBRARY Torch_C10_LIBRARY)
