// The kind of a file by its name.
#include "client/importer/extension.h"

#include <algorithm>
#include <cctype>

namespace sightline::client::importer {

std::string extension_of(std::string_view name) {
  std::string out(name.substr(std::min(name.size(), name.rfind('.') + 1)));
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return c < 0x80 ? std::tolower(c) : c; });
  return out;
}

}  // namespace sightline::client::importer
