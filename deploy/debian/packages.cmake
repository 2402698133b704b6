# Debian packages, one a component: `cpack` in the build directory makes them of what is built.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sightline)
set(CPACK_PACKAGE_CONTACT "Sightline <sightline@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_STRIP_FILES ON)
# Files are installed below / with the prefix /usr, so that settings come to /etc.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_COMPONENTS_ALL server client dev doc)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# package(COMPONENT SECTION DESCRIPTION): names it sightline-COMPONENT; the licence is in each.
function(package component section description)
  string(TOUPPER ${component} name)
  set(CPACK_DEBIAN_${name}_PACKAGE_NAME sightline-${component} PARENT_SCOPE)
  set(CPACK_DEBIAN_${name}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_COMPONENT_${name}_DESCRIPTION "${description}" PARENT_SCOPE)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/sightline-${component}
    RENAME copyright COMPONENT ${component})
endfunction()

package(server net "Ray-query server\n sightlined keeps scenes and answers batches of rays over gRPC.")
set(scripts ${PROJECT_SOURCE_DIR}/deploy/debian/server)
set(CPACK_DEBIAN_SERVER_PACKAGE_CONTROL_EXTRA ${scripts}/conffiles ${scripts}/postinst ${scripts}/prerm ${scripts}/postrm)
set(CPACK_DEBIAN_SERVER_PACKAGE_SUGGESTS "sightline-client, sightline-doc")

package(client graphics "Command for a ray-query server\n sightline imports scenes, casts rays, draws pictures.")
set(CPACK_DEBIAN_CLIENT_PACKAGE_SUGGESTS "sightline-server, sightline-doc")

package(dev libdevel "C++ client library of a ray-query server\n Static library, headers, protocol files.")
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libgrpc++-dev (>= 1.51), libprotobuf-dev, libssl-dev, libfmt-dev, pkg-config")
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS "sightline-doc, cmake")

package(doc doc "Manual of a ray-query server\n Pages on installing, operating, the protocol and how it works.")
set(CPACK_DEBIAN_DOC_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)

include(CPack)
