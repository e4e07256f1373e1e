# Recast and Detour as Debian and Ubuntu ship them: libraries and headers, no CMake or pkg-config file.
find_path(Recast_INCLUDE_DIR Recast.h PATH_SUFFIXES recastnavigation recast)
find_library(Recast_LIBRARY Recast)
find_library(Recast_DETOUR_LIBRARY Detour)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Recast
  REQUIRED_VARS Recast_LIBRARY Recast_DETOUR_LIBRARY Recast_INCLUDE_DIR)
if(Recast_FOUND AND NOT TARGET Recast::Recast)
  add_library(Recast::Recast UNKNOWN IMPORTED)
  set_target_properties(Recast::Recast PROPERTIES IMPORTED_LOCATION ${Recast_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${Recast_INCLUDE_DIR})
  add_library(Recast::Detour UNKNOWN IMPORTED)
  set_target_properties(Recast::Detour PROPERTIES IMPORTED_LOCATION ${Recast_DETOUR_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${Recast_INCLUDE_DIR})
endif()
mark_as_advanced(Recast_INCLUDE_DIR Recast_LIBRARY Recast_DETOUR_LIBRARY)
