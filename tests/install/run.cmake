# Installs the build, then configures, builds and runs its programs against the install.
file(REMOVE_RECURSE ${WORK})
function(step)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE out)
  message("${out}")
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "failed: ${ARGN}")
  endif()
endfunction()
step(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
# Without them the installed program would take those of the sources, if they are still there.
foreach(file python/plot.py python/ductile/pictures.py python/ductile/paper/report.html.j2
             python/ductile/paper/report.css python/ductile/paper/report.js Snakefile)
  if(NOT EXISTS ${WORK}/prefix/share/ductile/${file})
    message(FATAL_ERROR "share/ductile/${file} is not installed")
  endif()
endforeach()
step(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G ${GENERATOR}
     -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_BUILD_TYPE=Release
     -DCMAKE_CXX_FLAGS=${CXX_FLAGS})
# A project without C is told what it lacks.
file(WRITE ${WORK}/cxx/CMakeLists.txt [[
cmake_minimum_required(VERSION 3.25)
project(without_c LANGUAGES CXX)
find_package(ductile 0.1 REQUIRED)
]])
execute_process(COMMAND ${CMAKE_COMMAND} -S ${WORK}/cxx -B ${WORK}/cxx/build -G ${GENERATOR}
                        -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_CXX_COMPILER=${CXX}
                RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE out)
string(REGEX REPLACE "[ \n]+" " " out "${out}")
if(code EQUAL 0 OR NOT out MATCHES "ductile needs the language C for MPI: write project\\(... LANGUAGES C CXX\\)")
  message(FATAL_ERROR "a project without C: ${code}, ${out}")
endif()
step(${CMAKE_COMMAND} --build ${WORK}/build)
step(${WORK}/build/consumer)
step(${WORK}/build/two_capsules)
step(${MPIEXEC} --bind-to none --oversubscribe -n 2 ${WORK}/build/two_capsules)
step(${WORK}/prefix/bin/ductile --version)
