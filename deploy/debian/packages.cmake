# Debian packages, one a component: `cpack` in the build directory makes them of what is built.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sightline)
# Who made the packages, for dpkg. There is no mailbox of the project: `cpack -D CPACK_PACKAGE_CONTACT="NAME <ADDRESS>"` names yours.
set(CPACK_PACKAGE_CONTACT "Sightline developers <sightline@localhost.invalid>")
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_STRIP_FILES ON)
# Files are installed below / with the prefix /usr, so that settings come to /etc.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
# Each package has a summary of its own.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")
# What Debian asks of packages only: copyright, changelog, compressed pages.
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/finish.cmake)
set(CPACK_SIGHTLINE_COPYRIGHT ${CMAKE_CURRENT_LIST_DIR}/copyright)
set(CPACK_SIGHTLINE_CHANGES ${PROJECT_SOURCE_DIR}/CHANGELOG.md)

# package(COMPONENT NAME SECTION DESCRIPTION): what the component's package is called and said to be. The first line of the
# description is its summary.
function(package component name section description)
  string(TOUPPER ${component} upper)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${description}" PARENT_SCOPE)
endfunction()

package(server sightline-server net
  "ray-query server that builds its trees only where rays look\nsightlined keeps scenes and answers batches of rays over gRPC.")
set(scripts ${CMAKE_CURRENT_LIST_DIR}/server)
set(CPACK_DEBIAN_SERVER_PACKAGE_CONTROL_EXTRA ${scripts}/conffiles ${scripts}/postinst ${scripts}/prerm ${scripts}/postrm)
# For the server's user.
set(CPACK_DEBIAN_SERVER_PACKAGE_DEPENDS adduser)
set(CPACK_DEBIAN_SERVER_PACKAGE_SUGGESTS "sightline-client, sightline-doc, postgresql")

package(client sightline-client graphics
  "command for a ray-query server\nsightline imports scenes, casts rays at them and draws pictures.")
set(CPACK_DEBIAN_CLIENT_PACKAGE_SUGGESTS "sightline-server, sightline-doc")

package(dev sightline-dev libdevel
  "C++ client library of a ray-query server\nA static library, headers, files for CMake and pkg-config, the protocol.")
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libgrpc++-dev (>= 1.51), libprotobuf-dev, libssl-dev, libfmt-dev, pkg-config")
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS "sightline-doc, cmake")

package(doc sightline-doc doc
  "manual of a ray-query server\nPages on installing and operating Sightline, and on how it works.")
set(CPACK_DEBIAN_DOC_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)

if(TARGET sightline_wheel)
  package(python python3-sightline python
    "Python client of a ray-query server\nCasts NumPy arrays of rays into scenes of a Sightline server.")
  set(scripts ${CMAKE_CURRENT_LIST_DIR}/python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${scripts}/postinst ${scripts}/prerm)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS OFF)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
  # Debian counts protobuf's Python package as its C++ library: 3.21 is 4.21 elsewhere.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.9), python3-grpcio (>= 1.51), python3-protobuf (>= 3.21), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "sightline-server, sightline-doc, python3-pandas, python3-tqdm")
endif()

include(CPack)
