voropack_test(io_domain_test unit/io_domain_test.cpp)
voropack_test(io_mesh_test unit/io_mesh_test.cpp)
