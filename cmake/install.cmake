# What `cmake --install` leaves for other projects: libraries and headers in two components, `core` (what runs on a board:
# dictionary, stack, SII, devices, software ESC, SOES's API), `soes_hal` (that of a SOES firmware on a PC) and `host` (buses, the
# command), for find_package(ectwin) and for pkg-config.
include(CMakePackageConfigHelpers)

add_library(ectwin_core INTERFACE)
target_link_libraries(ectwin_core INTERFACE ectwin_devices ectwin_profiles ectwin_template ectwin_ports ectwin_virtual ectwin_esc
  ectwin_sii ectwin_slave ectwin_od)
if(TARGET ectwin_linux)
  target_link_libraries(ectwin_core INTERFACE ectwin_linux)
endif()
ectwin_export(ectwin_core core)
if(ECTWIN_HOST)
  add_library(ectwin_host INTERFACE)
  target_link_libraries(ectwin_host INTERFACE ectwin_command ectwin_core)
  ectwin_export(ectwin_host host)
endif()

# The pkg-config packages that a component's libraries link: NAME=MODULE each.
function(packages_of component result)
  get_property(libraries GLOBAL PROPERTY ECTWIN_LIBRARIES_${component})
  foreach(library IN LISTS libraries)
    get_target_property(links ${library} INTERFACE_LINK_LIBRARIES)
    string(REGEX MATCHALL "PkgConfig::[A-Z0-9_]+" found "${links}")
    foreach(package IN LISTS found)
      string(REPLACE PkgConfig:: "" name ${package})
      list(APPEND packages ${name}=${${name}_MODULE_NAME})
    endforeach()
  endforeach()
  list(REMOVE_DUPLICATES packages)
  set(${result} "${packages}" PARENT_SCOPE)
endfunction()

function(install_headers room component)
  get_filename_component(parent ${room} DIRECTORY)
  install(DIRECTORY src/${room} DESTINATION ${ECTWIN_INCLUDEDIR}/${parent} COMPONENT ${component}
    FILES_MATCHING PATTERN *.h PATTERN internal.h EXCLUDE PATTERN instance.h EXCLUDE PATTERN inprocess EXCLUDE)
endfunction()

file(GLOB ports RELATIVE ${CMAKE_CURRENT_SOURCE_DIR}/src CONFIGURE_DEPENDS src/ports/*)
list(REMOVE_ITEM ports ports/linux ports/soes_hal) # not everywhere
foreach(room wire od seams esc slave sii soes profiles devices ${ports})
  install_headers(${room} core)
endforeach()
if(TARGET ectwin_linux)
  install_headers(ports/linux core)
endif()
install(FILES src/soes/internal.h DESTINATION ${ECTWIN_INCLUDEDIR}/soes COMPONENT core) # for the sources beside it
if(ECTWIN_HOST)
  install_headers(ports/soes_hal soes_hal)
  foreach(room check bus)
    install_headers(${room} host)
  endforeach()
  install(FILES programs/ectwin/ectwin.h DESTINATION ${ECTWIN_INCLUDEDIR} COMPONENT host)
endif()

set(ECTWIN_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/ectwin)
set(ECTWIN_COMPONENTS core)
if(ECTWIN_HOST)
  list(APPEND ECTWIN_COMPONENTS soes_hal host)
endif()
packages_of(host ECTWIN_PACKAGES)
configure_package_config_file(cmake/ectwinConfig.cmake.in ${CMAKE_BINARY_DIR}/ectwinConfig.cmake
  INSTALL_DESTINATION ${ECTWIN_CMAKEDIR} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/ectwinConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/ectwinConfig.cmake ${CMAKE_BINARY_DIR}/ectwinConfigVersion.cmake
  DESTINATION ${ECTWIN_CMAKEDIR} COMPONENT core)

string(REGEX REPLACE "[^=;]+=" "" packages "${ECTWIN_PACKAGES}")
list(JOIN packages " " packages)
set(PC_REQUIRES_core "")
set(PC_REQUIRES_soes_hal "ectwin-core")
set(PC_REQUIRES_host "ectwin-soes_hal ${packages}")
set(PC_WHAT_soes_hal "a SOES firmware as an EtherCAT twin on a PC")
set(PC_WHAT_core "EtherCAT slave stack and devices, for a board or a host")
set(PC_WHAT_host "EtherCAT device twins: software ESC, buses, the command as a library")
file(RELATIVE_PATH PC_PREFIX ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
foreach(component IN LISTS ECTWIN_COMPONENTS)
  install(EXPORT ectwin-${component} NAMESPACE ectwin:: DESTINATION ${ECTWIN_CMAKEDIR} COMPONENT ${component})
  get_property(libraries GLOBAL PROPERTY ECTWIN_LIBRARIES_${component})
  list(REVERSE libraries) # a static library precedes the libraries that it needs
  list(TRANSFORM libraries PREPEND -l)
  list(JOIN libraries " " PC_LIBRARIES)
  set(PC_NAME ectwin-${component})
  set(PC_WHAT "${PC_WHAT_${component}}")
  set(PC_REQUIRES "${PC_REQUIRES_${component}}")
  configure_file(cmake/ectwin.pc.in ${PC_NAME}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${PC_NAME}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT ${component})
endforeach()
