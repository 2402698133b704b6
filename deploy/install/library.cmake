# The C++ library: archives, public headers, and how CMake and pkg-config find them.
include(CMakePackageConfigHelpers)

# In the sources a path begins with client/ or proto/, which other projects have too. The installed headers are
# <sightline/client/client.h> and so on, and include each other by those names.
set(headers
  client/async_call.h client/async_client.h client/backup.h client/cast_options.h client/client.h client/mesh_blob.h client/node_ref.h client/points.h
  client/prefetch.h client/ray_generator.h
  client/importer/imported_scene.h client/result.h client/scene_info.h client/scene_upload.h client/shared_memory.h client/types.h client/update.h client/update_stream.h
  proto/rays/generator.h proto/rays/point_grid.h proto/result.h)
set(renamed ${CMAKE_CURRENT_BINARY_DIR}/include)
foreach(header IN LISTS headers)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${header})
  file(READ ${PROJECT_SOURCE_DIR}/${header} text)
  string(REGEX REPLACE "#include \"(client|proto)/" "#include \"sightline/\\1/" text "${text}")
  file(CONFIGURE OUTPUT ${renamed}/sightline/${header} CONTENT "${text}" @ONLY)
endforeach()
install(DIRECTORY ${renamed}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev)

set(library_targets sightline_client sightline_proto sightline_rays)
foreach(target IN LISTS library_targets)
  string(REPLACE sightline_ "" name ${target})
  # Users link it into shared libraries too.
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
endforeach()
install(TARGETS ${library_targets} EXPORT SightlineTargets
  ARCHIVE COMPONENT dev
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/Sightline)
install(EXPORT SightlineTargets NAMESPACE Sightline:: DESTINATION ${package_folder} COMPONENT dev)
configure_package_config_file(SightlineConfig.cmake.in SightlineConfig.cmake INSTALL_DESTINATION ${package_folder})
# Before 1.0 a new minor version may change what programs are written against.
write_basic_package_version_file(SightlineConfigVersion.cmake COMPATIBILITY SameMinorVersion)
file(RELATIVE_PATH prefix_from_here /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(sightline.pc.in sightline.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/SightlineConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/SightlineConfigVersion.cmake
  DESTINATION ${package_folder} COMPONENT dev)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/sightline.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
