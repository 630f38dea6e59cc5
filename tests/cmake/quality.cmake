voropack_test(quality_test unit/quality_test.cpp support/delaunay_mesh.cpp)
