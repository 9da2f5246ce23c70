# Which component of an installation a library belongs to: `core` (runs on a board too), `soes_hal` (the software ESC for a SOES
# firmware on a PC), `host`, or `chain` (the bus as one shared library, whose file
# is the component `library`).
include(GNUInstallDirs)
set(ECTWIN_INCLUDEDIR ${CMAKE_INSTALL_INCLUDEDIR}/ectwin)

# ectwin_export(TARGET COMPONENT): TARGET is installed and known to others as ectwin::NAME, without the prefix ectwin_. Called for
# a library after those that it needs.
function(ectwin_export target component)
  string(REPLACE ectwin_ "" name ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  add_library(ectwin::${name} ALIAS ${target})
  install(TARGETS ${target} EXPORT ectwin-${component} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT ${component})
  get_target_property(type ${target} TYPE)
  if(NOT type STREQUAL INTERFACE_LIBRARY) # which has no file
    set_property(GLOBAL APPEND PROPERTY ECTWIN_LIBRARIES_${component} ${target})
  endif()
endfunction()
