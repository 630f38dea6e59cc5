add_library(certificate_case STATIC support/certificate_case.cpp support/delaunay_mesh.cpp)
target_link_libraries(certificate_case PRIVATE voropack_test_support voropack_flags)

voropack_test(certificate_filters_test property/certificate_filters_test.cpp)
foreach(name IN ITEMS unit/certificate_mesh_test unit/certificate_volumes_test property/certificate_robustness_test)
  get_filename_component(program ${name} NAME)
  voropack_test(${program} ${name}.cpp)
  target_link_libraries(${program} PRIVATE certificate_case)
endforeach()
