// Looks at the first characters of a file.
#include "client/importer/encoding.h"

#include <cstddef>

#include "client/importer/imported_scene.h"

namespace sightline::client::importer {
namespace {

constexpr std::string_view kLittleEndianMark = "\xff\xfe", kBigEndianMark = "\xfe\xff";
constexpr std::size_t kLooked = 32, kFewest = 8;  // bytes

// Whether every second byte, from `zero` on, is 0 and no other one is.
bool alternates(std::string_view bytes, std::size_t zero) {
  if (bytes.size() < kFewest) return false;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if ((bytes[i] == 0) != (i % 2 == zero)) return false;
  }
  return true;
}

}  // namespace

Status check_encoding(std::string_view bytes) {
  const bool marked = bytes.starts_with(kLittleEndianMark) || bytes.starts_with(kBigEndianMark);
  const std::string_view text = bytes.substr(marked ? 2 : 0, kLooked);
  if (!marked && !alternates(text, 0) && !alternates(text, 1)) return {};
  return import_error(
      "it is text in UTF-16, which is not read; save it as UTF-8, with iconv -f UTF-16 -t UTF-8, "
      "for example");
}

}  // namespace sightline::client::importer
