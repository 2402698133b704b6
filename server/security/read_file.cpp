// The content of a small file that an operator names.
#include "server/security/read_file.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <system_error>

namespace sightline::server::security {
namespace {

Error unreadable(const std::filesystem::path& file, const std::string& why) {
  return {Code::kFailedPrecondition, fmt::format("cannot read {}: {}", file.string(), why),
          "UNREADABLE_FILE"};
}

}  // namespace

Result<std::string> read_file(const std::filesystem::path& file, std::size_t limit) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) return unreadable(file, "it is a directory");
  std::ifstream in(file, std::ios::binary);
  if (!in) return unreadable(file, std::generic_category().message(errno));
  std::string content;
  std::array<char, 16384> part{};
  do {
    in.read(part.data(), part.size());
    content.append(part.data(), static_cast<std::size_t>(in.gcount()));
  } while (in && content.size() <= limit);
  if (in.bad()) return unreadable(file, std::generic_category().message(errno));
  if (content.size() > limit)
    return unreadable(file, fmt::format("it has more than {} bytes", limit));
  return content;
}

}  // namespace sightline::server::security
