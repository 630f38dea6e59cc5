voropack_test(dual_volumes_test unit/dual_volumes_test.cpp support/delaunay_mesh.cpp)
