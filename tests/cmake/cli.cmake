# Lint, the command line, the examples' domains, and strangers' projects.
# Debian's Python, which has meshio and vtk, before any other that may come first in the path.
find_program(VOROPACK_PYTHON NAMES python3 HINTS /usr/bin REQUIRED)

add_test(NAME lint/include_direction COMMAND ${VOROPACK_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/lint/include_direction.py)
add_test(NAME lint/include_direction_self_test
         COMMAND ${VOROPACK_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/lint/include_direction.py --self-test)
add_test(NAME lint/headers_alone
         COMMAND ${VOROPACK_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/lint/headers_alone.py ${CMAKE_CXX_COMPILER})

# Strangers' projects that build against us, as a subdirectory and installed.
foreach(way IN ITEMS find_package subdirectory)
  add_test(NAME consumer/${way}
           COMMAND ${CMAKE_COMMAND} -D WAY=${way} -D SOURCE=${PROJECT_SOURCE_DIR} -D BUILD=${PROJECT_BINARY_DIR}
                   -D WORK=${CMAKE_CURRENT_BINARY_DIR}/consumer/${way} -D COMPILER=${CMAKE_CXX_COMPILER}
                   -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/build.cmake)
  set_tests_properties(consumer/${way} PROPERTIES LABELS slow TIMEOUT 1200)
endforeach()

if(VOROPACK_BUILD_TOOLS)
  voropack_test(report_test unit/report_test.cpp)
  voropack_test(command_line_test unit/command_line_test.cpp)
  target_link_libraries(report_test PRIVATE voropack_app)
  target_link_libraries(command_line_test PRIVATE voropack_app)

  # One CTest test per class of tests, so that they run side by side and are counted.
  foreach(test IN ITEMS options outputs places robustness interrupt report mesh determinism check refine coarsen formats paper solve adapt run_scripts bench)
    add_test(NAME cli/${test}
             COMMAND ${VOROPACK_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/cli/${test}_test.py -v)
    set_tests_properties(cli/${test} PROPERTIES LABELS cli
      ENVIRONMENT "VOROPACK=$<TARGET_FILE:voropack_cli>;VOROPACK_SOURCE=${PROJECT_SOURCE_DIR}")
  endforeach()
  set_tests_properties(cli/bench cli/determinism cli/mesh cli/solve PROPERTIES LABELS "cli;slow")
endif()
