# SOEM, the master of the demo and of the tests. The one that find_package finds is taken when a program with the 1.4 interface
# compiles and links with it, and forgotten otherwise. Sets soem_FOUND.
find_package(soem CONFIG QUIET HINTS $ENV{HOME}/.cache/ectwin/soem-1.4.0) # of tools/bootstrap.sh
if(soem_FOUND)
  try_compile(fits ${CMAKE_BINARY_DIR}/soem_probe SOURCES ${CMAKE_CURRENT_LIST_DIR}/soem_probe.c LINK_LIBRARIES soem
    OUTPUT_VARIABLE log)
  if(NOT fits)
    string(REGEX MATCH "[^\n]*error: [^\n]*" reason "${log}")
    message(STATUS "The SOEM in ${soem_DIR} is not taken, it is not a SOEM 1.4 that works here: ${reason}")
    set(soem_FOUND FALSE)
    unset(soem_DIR CACHE)
  endif()
endif()
