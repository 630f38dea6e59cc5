voropack_test(multigrid_test unit/multigrid_test.cpp support/nested_hierarchy.cpp support/delaunay_mesh.cpp)
voropack_test(smoother_test unit/smoother_test.cpp support/nested_hierarchy.cpp support/delaunay_mesh.cpp)
voropack_test(multigrid_property_test property/multigrid_property_test.cpp support/nested_hierarchy.cpp
                                      support/delaunay_mesh.cpp)
