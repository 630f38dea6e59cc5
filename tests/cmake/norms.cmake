voropack_test(quadrature_test unit/quadrature_test.cpp)
voropack_test(norms_test unit/norms_test.cpp support/delaunay_mesh.cpp)
