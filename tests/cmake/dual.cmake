voropack_test(dual_volumes_test unit/dual_volumes_test.cpp support/delaunay_mesh.cpp)
voropack_test(dual_shapes_test unit/dual_shapes_test.cpp support/delaunay_mesh.cpp)
voropack_test(dual_reference_test property/dual_reference_test.cpp support/delaunay_mesh.cpp)
target_link_libraries(dual_reference_test PRIVATE gmpxx gmp)
