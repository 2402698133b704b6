// A table of suffixes.
#include "client/cli/files/format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

const std::map<std::string, Format> kSuffixes{
    {".csv", Format::kCsv},      {".txt", Format::kCsv}, {".ndjson", Format::kNdjson},
    {".jsonl", Format::kNdjson}, {".npy", Format::kNpy}, {".npz", Format::kNpz},
    {".ply", Format::kPly}};

}  // namespace

const std::map<std::string, Format> kFormats{{"csv", Format::kCsv},
                                             {"ndjson", Format::kNdjson},
                                             {"npy", Format::kNpy},
                                             {"npz", Format::kNpz},
                                             {"ply", Format::kPly}};

Result<std::optional<Format>> format_of(const std::string& path) {
  std::string suffix = std::filesystem::path(path).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (suffix.empty()) return std::optional<Format>();
  const auto found = kSuffixes.find(suffix);
  if (found != kSuffixes.end()) return std::optional(found->second);
  return local_error(
      fmt::format("{}: {} is no suffix of rays or hits: .csv .txt .ndjson .jsonl "
                  ".npy .npz .ply are",
                  path, suffix));
}

}  // namespace sightline::client::cli::files
