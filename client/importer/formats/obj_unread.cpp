// Statements about looks are silent; those that may add a surface, and unknown ones, are counted.
#include "client/importer/formats/obj_unread.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "client/importer/formats/text.h"

namespace sightline::client::importer::formats {
namespace {

// Normals, texture coordinates, materials, display, and what only curves and surfaces use.
constexpr std::string_view kSilent[] = {
    "vn",     "vt",    "vp",   "s",          "mtllib",    "maplib", "usemap",
    "mg",     "bevel", "lod",  "shadow_obj", "trace_obj", "ctech",  "stech",
    "cstype", "deg",   "bmat", "step",       "parm",      "trim",   "hole",
    "scrv",   "sp",    "end",  "c_interp",   "d_interp",  "con",    "res"};
constexpr std::string_view kCurves[] = {"curv", "curv2", "surf", "cdc", "cdp", "bzp", "bsp"};
constexpr std::string_view kCalls[] = {"call", "csh"};

template <class Words>
bool holds(const Words& words, std::string_view word) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

}  // namespace

void ObjUnread::Count::add(std::uint64_t line, std::string_view keyword) {
  if (count++ > 0) return;
  first = fmt::format("line {}", line);
  if (!keyword.empty()) first += fmt::format(": {}", shown(keyword));
}

void ObjUnread::statement(std::string_view keyword, std::uint64_t line) {
  if (holds(kSilent, keyword)) return;
  Count& count = holds(kCurves, keyword) ? curves_ : holds(kCalls, keyword) ? calls_ : unknown_;
  count.add(line, keyword);
}

void ObjUnread::weight(std::uint64_t line) { weights_.add(line); }
void ObjUnread::empty_face(std::uint64_t line) { empty_faces_.add(line); }
void ObjUnread::end_of_last_line() { has_last_line_end_ = false; }

std::vector<Warning> ObjUnread::warnings() const {
  std::vector<Warning> warnings;
  const auto warn = [&](const Count& count, const char* kind, const char* what) {
    if (count.count == 0) return;
    warnings.push_back({kind, count.count, count.first,
                        fmt::format("{} {} (first in {})", count.count, what, count.first)});
  };
  warn(curves_, "curves_and_surfaces", "curves and free-form surfaces are not read");
  warn(calls_, "calls", "calls of other files and programs are not followed");
  warn(unknown_, "unknown_statements", "lines begin with an unknown word and are not read");
  warn(weights_, "vertex_weights",
       "vertices have a weight other than 1, which polygons do not use");
  warn(empty_faces_, "empty_faces", "faces have no corner and are left out");
  if (!has_last_line_end_) {
    warnings.push_back({"cut_off", 1, "", "its last line has no end; the file may be cut off"});
  }
  return warnings;
}

}  // namespace sightline::client::importer::formats
