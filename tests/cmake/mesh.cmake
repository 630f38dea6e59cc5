voropack_test(mesh_test unit/mesh_test.cpp)
