# Run by cpack on the files of each component, before they become packages: copyright, changelogs and manual pages are where
# and as Debian wants them.
find_program(gzip gzip REQUIRED)

# compress(FILE): as FILE.gz, the same for the same content.
function(compress file)
  execute_process(COMMAND ${gzip} -9nf ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# The entry that dpkg's tools read; what has changed is in the other changelog.
string(TIMESTAMP day "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(version ${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} upper)
  set(name ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(root ${CPACK_TEMPORARY_DIRECTORY}/${component})
  set(documents ${root}/usr/share/doc/${name})

  file(MAKE_DIRECTORY ${documents})
  file(COPY_FILE ${CPACK_SIGHTLINE_CHANGES} ${documents}/changelog)
  file(WRITE ${documents}/changelog.Debian "${name} (${version}) unstable; urgency=medium

  * Version ${CPACK_PACKAGE_VERSION} of Sightline: see changelog.gz.

 -- ${CPACK_PACKAGE_CONTACT}  ${day}
")
  file(COPY ${CPACK_SIGHTLINE_COPYRIGHT} DESTINATION ${documents})
  compress(${documents}/changelog)
  compress(${documents}/changelog.Debian)

  file(GLOB pages ${root}/usr/share/man/man*/*)
  foreach(page IN LISTS pages)
    compress(${page})
  endforeach()
endforeach()
