# Installs the library, its headers and a package file, so that `find_package(voropack)` works for others.
include(CMakePackageConfigHelpers)

install(TARGETS voropack EXPORT voropackTargets FILE_SET HEADERS)
install(EXPORT voropackTargets NAMESPACE voropack:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/voropack)
configure_package_config_file(cmake/voropackConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/voropackConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/voropack)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/voropackConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/voropackConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/voropackConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/voropack)
