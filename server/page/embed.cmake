# Writes a source file that holds the files of the live page.
#
#   cmake -D FILES=FILE;... -D OUT=FILE -P embed.cmake
set(types .html=text/html .css=text/css .js=text/javascript .pb=application/octet-stream)
set(arrays "")
set(table "")
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  get_filename_component(suffix ${file} LAST_EXT)
  foreach(type IN LISTS types)
    if(type MATCHES "^\\${suffix}=(.*)$")
      set(media ${CMAKE_MATCH_1})
    endif()
  endforeach()
  if(NOT suffix STREQUAL ".pb")
    string(APPEND media "; charset=utf-8")
  endif()
  set(path /page/${name})
  if(name STREQUAL index.html)
    set(path /)
  endif()
  string(MAKE_C_IDENTIFIER ${name} identifier)
  file(READ ${file} content HEX)
  string(REGEX REPLACE "(................................)" "\\1\n" content "${content}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," content "${content}")
  string(APPEND arrays "constexpr unsigned char k_${identifier}[] = {\n${content}};\n")
  string(APPEND table "    {\"${path}\", \"${media}\", text(k_${identifier})},\n")
endforeach()
file(WRITE ${OUT} "// Made by server/page/embed.cmake.
#include \"server/admin/pages.h\"

namespace sightline::server::admin {
namespace {

${arrays}
template <std::size_t kSize>
std::string_view text(const unsigned char (&bytes)[kSize]) {
  return {reinterpret_cast<const char*>(bytes), kSize};
}

}  // namespace

std::span<const PageFile> page_files() {
  static const PageFile kFiles[] = {
${table}  };
  return kFiles;
}

}  // namespace sightline::server::admin
")
