voropack_test(io_domain_test unit/io_domain_test.cpp)
voropack_test(io_mesh_test unit/io_mesh_test.cpp)

# Other programs read what we write. The Python of Debian has vtk and meshio; without them the test is skipped.
add_executable(io_write_samples io/write_samples.cpp)
target_link_libraries(io_write_samples PRIVATE voropack_test_support)
set(io_samples ${CMAKE_CURRENT_BINARY_DIR}/io_samples)
add_test(NAME io/write_samples COMMAND io_write_samples ${io_samples})
set_tests_properties(io/write_samples PROPERTIES FIXTURES_SETUP io_samples)
find_program(VOROPACK_DEBIAN_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
if(VOROPACK_DEBIAN_PYTHON)
  add_test(NAME io/check_vtu COMMAND ${VOROPACK_DEBIAN_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/io/check_vtu.py ${io_samples})
  set_tests_properties(io/check_vtu PROPERTIES FIXTURES_REQUIRED io_samples SKIP_RETURN_CODE 77)
endif()

voropack_test(io_mutation_test property/io_mutation_test.cpp)
if(VOROPACK_BUILD_FUZZ)
  add_subdirectory(fuzz)
endif()
