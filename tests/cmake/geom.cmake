voropack_test(predicates_test unit/predicates_test.cpp)
target_link_libraries(predicates_test PRIVATE gmpxx gmp)
voropack_test(expansion_test unit/expansion_test.cpp)
target_link_libraries(expansion_test PRIVATE gmpxx gmp)
