# Installs the unit and the settings of deploy/systemd. Paths in them are those of an installation to /usr, whose
# settings are in /etc; other prefixes have bin and etc below them.
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  set(settings_folder /etc/sightline)
else()
  set(settings_folder ${CMAKE_INSTALL_PREFIX}/etc/sightline)
endif()

file(READ ${service_files}/sightlined.service unit)
string(REPLACE /usr/ "${CMAKE_INSTALL_PREFIX}/" unit "${unit}")
string(REPLACE /etc/sightline "${settings_folder}" unit "${unit}")

set(unit_folder ${CMAKE_INSTALL_PREFIX}/lib/systemd/system)
message(STATUS "Installing: $ENV{DESTDIR}${unit_folder}/sightlined.service")
file(WRITE "$ENV{DESTDIR}${unit_folder}/sightlined.service" "${unit}")
list(APPEND CMAKE_INSTALL_MANIFEST_FILES ${unit_folder}/sightlined.service)

# Settings that someone has changed stay.
if(NOT EXISTS "$ENV{DESTDIR}${settings_folder}/sightlined.toml")
  file(INSTALL ${service_files}/sightlined.toml DESTINATION ${settings_folder})
endif()
