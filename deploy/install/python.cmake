# The Python package as a wheel, beside the packages of cpack, and as the component python: the wheel's content, where Debian's
# Python looks for packages. Elsewhere `pip install` of the wheel is the way, so that it is installed only when it is asked for.
if(NOT TARGET sightline_python)
  return()
endif()
# The wheel is for all versions of Python, so that any one can make it.
find_package(Python3 COMPONENTS Interpreter QUIET)
foreach(candidate IN ITEMS ${Python3_EXECUTABLE} /usr/bin/python3)
  set(python ${candidate})
  execute_process(COMMAND ${python} -c "import setuptools, wheel" RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
  if(NOT failed)
    break()
  endif()
endforeach()
if(failed)
  message(STATUS "No wheel: ${python} lacks setuptools or wheel")
  return()
endif()

set(wheel ${PROJECT_BINARY_DIR}/sightline-${PROJECT_VERSION}-py3-none-any.whl)
set(made ${CMAKE_CURRENT_BINARY_DIR}/wheel)
set(unpacked ${CMAKE_CURRENT_BINARY_DIR}/python)
file(MAKE_DIRECTORY ${made} ${unpacked})
# All that setuptools writes is in the build directory.
add_custom_command(
  OUTPUT ${wheel}
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${made} ${unpacked}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${made} ${unpacked}
  COMMAND ${CMAKE_COMMAND} -E env PYTHONPYCACHEPREFIX=${made} ${python} -W ignore setup.py --quiet egg_info --egg-base ${made}
          build --build-base ${made}/build bdist_wheel --dist-dir ${PROJECT_BINARY_DIR}
  COMMAND ${CMAKE_COMMAND} -E chdir ${unpacked} ${CMAKE_COMMAND} -E tar xf ${wheel}
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}/client/python
  DEPENDS sightline_python ${PROJECT_BINARY_DIR}/client/python/sightline/_proto/descriptors.binpb
  VERBATIM)
add_custom_target(sightline_wheel ALL DEPENDS ${wheel})

# RECORD is pip's list of what it may remove; these files are dpkg's.
install(DIRECTORY ${unpacked}/ DESTINATION lib/python3/dist-packages COMPONENT python EXCLUDE_FROM_ALL
  PATTERN RECORD EXCLUDE)
