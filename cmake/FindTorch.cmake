# libtorch as Debian and Ubuntu ship it, or the one inside a PyTorch that pip installed
# (-DCMAKE_PREFIX_PATH=.../site-packages/torch). Its own CMake files are not asked: those of a PyTorch for
# CUDA want the CUDA compiler, which nobody needs who has no kernel of his own.
find_path(Torch_INCLUDE_DIR ATen/ATen.h)
find_library(Torch_LIBRARY torch)
find_library(Torch_CPU_LIBRARY torch_cpu)
find_library(Torch_C10_LIBRARY c10)
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
endif()
mark_as_advanced(Torch_INCLUDE_DIR Torch_LIBRARY Torch_CPU_LIBRARY Torch_C10_LIBRARY)
