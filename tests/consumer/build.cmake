# Builds and runs a stranger's project: cmake -D WAY=find_package|subdirectory -D SOURCE -D BUILD -D WORK -D COMPILER -P
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "failed (${result}): ${command}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
set(options -D VOROPACK_SOURCE=${SOURCE} -D CMAKE_CXX_FLAGS=-O0)
if(WAY STREQUAL "find_package")
  run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
  set(options -D CMAKE_PREFIX_PATH=${WORK}/prefix)
endif()
run(${CMAKE_COMMAND} -S ${SOURCE}/tests/consumer/${WAY} -B ${WORK}/build -G Ninja -D CMAKE_CXX_COMPILER=${COMPILER}
    --no-warn-unused-cli ${options})
run(${CMAKE_COMMAND} --build ${WORK}/build --target consumer)
run(${WORK}/build/consumer)
