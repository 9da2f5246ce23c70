# The rest of an installed tree, beside programs and libraries. Component `runtime`: ESI files and EEPROM images, made by the
# `ectwin` that was built. Component `doc`: manual pages, made from the programs' help; the pages; examples; the system service;
# completion.
set(share ${CMAKE_BINARY_DIR}/share)

add_custom_command(OUTPUT ${share}/esi.stamp
  COMMAND ${CMAKE_COMMAND} -DECTWIN=$<TARGET_FILE:ectwin> -DOUT=${share}/ectwin/esi -P ${CMAKE_CURRENT_LIST_DIR}/esi.cmake
  COMMAND ${CMAKE_COMMAND} -E touch ${share}/esi.stamp
  DEPENDS ectwin cmake/esi.cmake VERBATIM)
set(products ${share}/esi.stamp)
install(DIRECTORY ${share}/ectwin/esi DESTINATION ${CMAKE_INSTALL_DATADIR}/ectwin COMPONENT runtime)

find_package(Python3 COMPONENTS Interpreter QUIET)
if(Python3_FOUND)
  file(GLOB templates CONFIGURE_DEPENDS packaging/man/*.1.in)
  foreach(template IN LISTS templates)
    get_filename_component(program ${template} NAME_WLE)
    get_filename_component(program ${program} NAME_WLE)
    if(TARGET ${program})
      set(page ${share}/man/man1/${program}.1)
      set(started "") # `ectwin panel --help` is the help of ectwin-panel
      if(program STREQUAL ectwin AND TARGET ectwin-panel)
        set(started ectwin-panel)
      endif()
      add_custom_command(OUTPUT ${page}
        COMMAND ${CMAKE_COMMAND} -E make_directory ${share}/man/man1
        COMMAND Python3::Interpreter tools/dev/man.py ${template} $<TARGET_FILE:${program}> ${PROJECT_VERSION} ${page}
        DEPENDS ${template} ${program} ${started} tools/dev/man.py WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} VERBATIM)
      list(APPEND products ${page})
      install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT doc)
    endif()
  endforeach()
else()
  message(STATUS "Python 3 not found: the manual pages are left out")
endif()
add_custom_target(ectwin_share ALL DEPENDS ${products})

if(soem_FOUND AND EXISTS ${soem_DIR}/../LICENSE AND NOT ECTWIN_DEBIAN) # of the programs that link SOEM; Debian: its copyright file
  install(FILES ${soem_DIR}/../LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/ectwin RENAME SOEM-LICENCE COMPONENT runtime)
endif()
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT doc)
# Modes are not those of the sources, which depend on the umask of the clone.
install(DIRECTORY docs examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT doc
  PATTERN Doxyfile EXCLUDE PATTERN __pycache__ EXCLUDE
  REGEX "/(machine\\.sh|tank\\.sh|tank\\.py|tank_fmu\\.py|plot\\.py|ten_lines_chain\\.py)$" PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
install(FILES packaging/systemd/ectwin@.service DESTINATION lib/systemd/system COMPONENT doc)
foreach(row "ectwin.bash bash-completion/completions ectwin" "_ectwin zsh/vendor-completions _ectwin"
    "ectwin.fish fish/vendor_completions.d ectwin.fish") # file, folder, name
  separate_arguments(row)
  list(GET row 0 file)
  list(GET row 1 folder)
  list(GET row 2 name)
  file(GLOB found packaging/completion/${file})
  if(found)
    install(FILES ${found} DESTINATION ${CMAKE_INSTALL_DATADIR}/${folder} RENAME ${name} COMPONENT doc)
  endif()
endforeach()
