voropack_test(domain_test unit/domain_test.cpp)
