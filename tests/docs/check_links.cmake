# Reports every relative link of a Markdown file, and every `path/file.ext` in backquotes, that leads nowhere.
#
#   cmake -D ROOT=<checkout> -P tests/docs/check_links.cmake
cmake_minimum_required(VERSION 3.25)

file(GLOB files "${ROOT}/*.md" "${ROOT}/docs/*.md" "${ROOT}/docs/charts/*.md" "${ROOT}/docs/decisions/*.md")
set(broken "")
set(checked 0)
foreach(file IN LISTS files)
  file(READ "${file}" text)
  # Brackets and semicolons mean something in CMake's lists.
  string(REPLACE ";" "," text "${text}")
  string(REPLACE "[" "(" text "${text}")
  string(REPLACE "]" ")" text "${text}")
  cmake_path(GET file PARENT_PATH folder)
  cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${ROOT}" OUTPUT_VARIABLE name)

  string(REGEX REPLACE "`[^`\n]*`" "" prose "${text}")
  string(REGEX MATCHALL "\\)\\([^() \n]+\\)" links "${prose}")
  foreach(link IN LISTS links)
    string(REGEX REPLACE "^\\)\\(([^#]*)(#.*)?\\)$" "\\1" target "${link}")
    if(target STREQUAL "" OR target MATCHES "^[a-z]+:")
      continue()
    endif()
    math(EXPR checked "${checked} + 1")
    if(NOT EXISTS "${folder}/${target}")
      list(APPEND broken "${name} links to ${target}")
    endif()
  endforeach()

  string(REGEX MATCHALL "`(accel|scenegraph|server|client|proto|tests|docs|deploy)/[a-z_0-9/]+\\.(h|cpp|proto|txt|md)`"
    paths "${text}")
  foreach(path IN LISTS paths)
    string(REPLACE "`" "" path "${path}")
    math(EXPR checked "${checked} + 1")
    if(NOT EXISTS "${ROOT}/${path}")
      list(APPEND broken "${name} names ${path}")
    endif()
  endforeach()
endforeach()

list(LENGTH broken count)
foreach(line IN LISTS broken)
  message("${line}, which does not exist")
endforeach()
if(count GREATER 0 OR checked EQUAL 0)
  message(FATAL_ERROR "${count} of ${checked} links and paths lead nowhere")
endif()
message("${checked} links and paths, all there")
