# Reports every #include against the direction of dependencies. Fails if there is one.
#
#   cmake -D ROOT=<checkout> -P tests/layers/check_layers.cmake
cmake_minimum_required(VERSION 3.25)

# Which of the project's own headers a folder may include, as prefixes. The most specific folder counts.
set(folders accel scenegraph server client/importer client)
set(own_accel accel/)
set(own_scenegraph accel/ scenegraph/)
set(own_server accel/ scenegraph/ server/ sightline/v1/ google/rpc/)
set(own_client client/ sightline/v1/ google/rpc/)
# Scene files are read apart from the connection: plain arrays and errors, no message, no call.
set(own_client/importer client/importer/ client/mesh_arrays.h client/result.h client/transform.h client/up_axis.h)

# Which folders may include a package, by the first part of the header's path.
set(packages
  "tbb=accel scenegraph server"
  "oneapi=accel scenegraph server"
  "hwy=accel"
  "grpc=server client"
  "grpcpp=server client"
  "google/protobuf=server client"
  "fmt=server client client/importer"
  "spdlog=server"
  "openssl=server client"
  "CLI=server client"
  "nlohmann=server client client/importer"
  "png.h=client"
  "assimp=client/importer")

# Headers of the system: the standard library's and POSIX's have no folder, or one of these.
set(system_folders sys netinet arpa)

# Sets `why` to the reason why `folder` may not include `header`, or to nothing.
function(judge folder header quoted why)
  set(${why} "" PARENT_SCOPE)
  foreach(prefix IN LISTS own_${folder})
    string(FIND "${header}" "${prefix}" at)
    if(at EQUAL 0)
      return()
    endif()
  endforeach()
  string(REGEX MATCH "^[^/]+" top "${header}")
  if(top MATCHES "^(accel|scenegraph|server|client|tests|proto|sightline)$" OR header MATCHES "^google/rpc/")
    set(${why} "${folder} may not depend on it" PARENT_SCOPE)
    return()
  endif()
  foreach(rule IN LISTS packages)
    string(REGEX MATCH "^([^=]+)=(.*)$" matched "${rule}")
    set(package "${CMAKE_MATCH_1}")
    string(REPLACE " " ";" users "${CMAKE_MATCH_2}")
    if("${header}/" MATCHES "^${package}/")
      if(NOT folder IN_LIST users)
        list(JOIN users ", " users)
        set(${why} "only ${users} may use this package" PARENT_SCOPE)
      endif()
      return()
    endif()
  endforeach()
  if(quoted)
    set(${why} "paths start at the root of the repository" PARENT_SCOPE)
  elseif(header MATCHES "/" AND NOT top IN_LIST system_folders)
    set(${why} "a package that tests/layers does not know" PARENT_SCOPE)
  endif()
endfunction()

set(checked 0)
set(violations "")
foreach(folder IN LISTS folders)
  file(GLOB_RECURSE files RELATIVE "${ROOT}" "${ROOT}/${folder}/*.h" "${ROOT}/${folder}/*.cpp")
  foreach(file IN LISTS files)
    if(folder STREQUAL client AND file MATCHES "^client/importer/")
      continue()
    endif()
    math(EXPR checked "${checked} + 1")
    file(STRINGS "${ROOT}/${file}" lines REGEX "^[ \t]*#[ \t]*include[ \t]*[<\"]")
    foreach(line IN LISTS lines)
      string(REGEX MATCH "include[ \t]*([<\"])([^>\"]+)[>\"]" matched "${line}")
      set(header "${CMAKE_MATCH_2}")
      string(COMPARE EQUAL "${CMAKE_MATCH_1}" "\"" quoted)
      judge("${folder}" "${header}" ${quoted} why)
      if(why)
        list(APPEND violations "${file} includes ${header}: ${why}")
      endif()
    endforeach()
  endforeach()
endforeach()

if(checked EQUAL 0)
  message(FATAL_ERROR "no source file under \"${ROOT}\"")
endif()
list(LENGTH violations count)
foreach(violation IN LISTS violations)
  message("${violation}")
endforeach()
if(count GREATER 0)
  message(FATAL_ERROR "${count} of the includes in ${checked} files go against the direction of dependencies")
endif()
message("${checked} files, all includes in the direction of dependencies")
