voropack_test(fem_test unit/fem_test.cpp support/delaunay_mesh.cpp)
