voropack_test(mesh_domain_test unit/mesh_domain_test.cpp)
voropack_test(coarsening_test property/coarsening_test.cpp)
