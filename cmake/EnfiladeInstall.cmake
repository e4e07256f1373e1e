# cmake --install, and a package config so that find_package(enfilade) works from the prefix.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The umbrella: everything, for people who don't care which folder a name is in.
get_property(libraries GLOBAL PROPERTY ENFILADE_LIBRARIES)
add_library(enfilade_all INTERFACE)
add_library(enfilade::enfilade ALIAS enfilade_all)
set_target_properties(enfilade_all PROPERTIES EXPORT_NAME enfilade)
target_link_libraries(enfilade_all INTERFACE ${libraries})
install(TARGETS enfilade_all EXPORT enfilade)

install(FILES enfilade/enfilade.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/enfilade)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(EXPORT enfilade NAMESPACE enfilade:: FILE enfiladeTargets.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/enfilade)
configure_package_config_file(cmake/enfiladeConfig.cmake.in
  ${PROJECT_BINARY_DIR}/enfiladeConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/enfilade)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/enfiladeConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES cmake/FindRecast.cmake cmake/FindTorch.cmake cmake/TorchNccl.cmake
  ${PROJECT_BINARY_DIR}/enfiladeConfig.cmake ${PROJECT_BINARY_DIR}/enfiladeConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/enfilade)
