// Listens to Assimp's logger.
#include "client/importer/assimp_complaints.h"

#include <fmt/format.h>

#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <iterator>
#include <utility>

namespace sightline::client::importer {
namespace {

constexpr unsigned kHeard = Assimp::Logger::Err | Assimp::Logger::Warn;
constexpr std::size_t kMostComplaints = 3;
// They are followed by the number of a thread, and a colon.
constexpr std::string_view kPrefixes[] = {"Error, T", "Warn,  T"};

// Parts of sentences about materials, textures, lights and cameras, which are not imported, and of
// those after which the scene is as it should be: FBX files are newer than Assimp says it knows,
// IFC faces are compared with others, and IFC items are counted (ifc_products.h).
constexpr std::string_view kHarmless[] = {"aterial",
                                          "exture",
                                          "angent layer",
                                          "inormal layer",
                                          "hading",
                                          "UV",
                                          "vertex color",
                                          "normal layer",
                                          "olour",
                                          "surface side marker",
                                          "SpecularHighlight",
                                          "find light",
                                          "find camera",
                                          " light,",
                                          "cubic attenuation",
                                          "Orthographic cameras",
                                          "image file format",
                                          "video content",
                                          "newer format version",
                                          "property table (Properties70) not found",
                                          "is not parallel with face",
                                          "IfcGeometricRepresentationItem",
                                          "skipping mapped entity"};

bool is_harmless(std::string_view line) {
  return std::any_of(std::begin(kHarmless), std::end(kHarmless),
                     [&](std::string_view part) { return line.find(part) != line.npos; });
}

}  // namespace

std::string one_line(std::string_view text) {
  std::string line(text.substr(0, text.find_last_not_of(" \t\r\n") + 1));
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return line;
}

AssimpComplaints::AssimpComplaints() {
  Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0)->attachStream(&stream_, kHeard);
}

AssimpComplaints::~AssimpComplaints() {
  Assimp::DefaultLogger::get()->detachStream(&stream_, kHeard);
  Assimp::DefaultLogger::kill();
}

std::vector<std::string> AssimpComplaints::take() {
  if (stream_.more > 0)
    stream_.lines.push_back(fmt::format("{} more complaints, and went on", stream_.more));
  return std::move(stream_.lines);
}

void AssimpComplaints::Stream::write(const char* text) {
  std::string line = one_line(text);
  for (const std::string_view prefix : kPrefixes) {
    if (line.starts_with(prefix)) line.erase(0, line.find(": ") + 2);
  }
  if (is_harmless(line) || std::find(lines.begin(), lines.end(), line) != lines.end()) return;
  if (lines.size() < kMostComplaints) {
    lines.push_back(std::move(line));
  } else {
    ++more;
  }
}

}  // namespace sightline::client::importer
