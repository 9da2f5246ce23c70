# Debian packages by CPack, for tools/package.sh: ectwin (components runtime, library, doc), ectwin-dev (headers and static libraries).
option(ECTWIN_DEBIAN "Lay out the installed tree as a Debian package" OFF)
set(ECTWIN_MAINTAINER "ectwin maintainers <maintainers@ectwin.example>" CACHE STRING "Maintainer of the Debian packages")

if(ECTWIN_PYTHON_DIR)
  install(DIRECTORY python/ectwin DESTINATION ${ECTWIN_PYTHON_DIR} COMPONENT runtime PATTERN __pycache__ EXCLUDE)
endif()
if(NOT ECTWIN_DEBIAN)
  return()
endif()

set(debian ${CMAKE_BINARY_DIR}/debian)
execute_process(COMMAND tools/dev/debian.py . ${debian} ${ECTWIN_MAINTAINER} ${soem_DIR}/../LICENSE
  WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} COMMAND_ERROR_IS_FATAL ANY)
if(ECTWIN_PYTHON_DIR)
  install(DIRECTORY ${debian}/dist-info/ DESTINATION ${ECTWIN_PYTHON_DIR}/ectwin-${PROJECT_VERSION}.dist-info COMPONENT runtime)
endif()
foreach(row "ectwin doc" "ectwin-dev host")
  separate_arguments(row)
  list(GET row 0 package)
  list(GET row 1 component)
  install(FILES ${debian}/copyright ${debian}/changelog.gz ${debian}/changelog.Debian.gz
    DESTINATION share/doc/${package} COMPONENT ${component})
  install(FILES packaging/debian/${package}.lintian-overrides DESTINATION share/lintian/overrides RENAME ${package}
    COMPONENT ${component})
endforeach()
install(FILES packaging/debian/README.Debian DESTINATION share/doc/ectwin COMPONENT doc)
# Debian compresses manual pages, and keeps licence and changes in files of its own.
install(CODE "
  set(tree \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
  file(GLOB pages \"\${tree}/share/man/man1/*.1\")
  if(pages)
    execute_process(COMMAND gzip -9nf \${pages} COMMAND_ERROR_IS_FATAL ANY)
  endif()
  file(REMOVE \"\${tree}/share/doc/ectwin/LICENSE\" \"\${tree}/share/doc/ectwin/CHANGELOG.md\")
" COMPONENT doc)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ectwin)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT ${ECTWIN_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_COMPONENTS_ALL runtime library doc core soes_hal host chain)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_MAIN_PACKAGE_NAME ectwin)
set(CPACK_DEBIAN_MAIN_PACKAGE_SECTION net)
set(CPACK_DEBIAN_MAIN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_MAIN_PACKAGE_RECOMMENDS "python3 (>= 3.8)")
set(CPACK_DEBIAN_MAIN_PACKAGE_SUGGESTS "libcap2-bin, python3-pytest")
file(WRITE ${debian}/shlibs "libectwin 0 ectwin (>= ${PROJECT_VERSION})\n")
file(CHMOD ${debian}/shlibs PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
set(CPACK_DEBIAN_MAIN_PACKAGE_CONTROL_EXTRA ${debian}/shlibs ${CMAKE_SOURCE_DIR}/packaging/debian/postinst
  ${CMAKE_SOURCE_DIR}/packaging/debian/postrm ${CMAKE_SOURCE_DIR}/packaging/debian/triggers)
string(CONCAT CPACK_DEBIAN_MAIN_DESCRIPTION "ectwin puts EtherCAT slaves on a network interface without EtherCAT\n"
  "hardware. A software EtherCAT slave controller answers a real, unmodified\n"
  "master over a veth pair or a spare NIC; behind it run a slave stack and the\n"
  "application of a real product.\n.\n"
  "The package has the devices, a conformance runner for any slave, example\n"
  "masters, a Python module, ESI files and EEPROM images.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME ectwin-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
string(CONCAT depends "ectwin (= ${PROJECT_VERSION}-1), libcjson-dev, libmodbus-dev, libnl-route-3-dev, libseccomp-dev, libxml2-dev, libyaml-dev")
if("${ECTWIN_PACKAGES}" MATCHES "libbpf") # a static library needs it: this build replies in the kernel
  string(APPEND depends ", libbpf-dev")
endif()
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ${depends})
string(CONCAT CPACK_DEBIAN_DEV_DESCRIPTION "Headers and static libraries of ectwin: dictionary, slave stack, software\n"
  "EtherCAT slave controller, devices, SOES's API, buses and the command as a\n"
  "library, for CMake and pkg-config.")

include(CPack)
cpack_add_component_group(main)
cpack_add_component_group(dev)
foreach(component runtime library doc)
  cpack_add_component(${component} GROUP main)
endforeach()
foreach(component core soes_hal host chain)
  cpack_add_component(${component} GROUP dev)
endforeach()
