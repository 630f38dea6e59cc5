voropack_test(mesh_test unit/mesh_test.cpp)
voropack_test(retriangulate_test unit/retriangulate_test.cpp support/delaunay_mesh.cpp)
