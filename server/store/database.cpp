// A connection to a database, by which the tables of a store are read and written.
#include "server/store/database.h"

namespace sightline::server::store {

std::string Row::copy_of_bytes(int column) const {
  const auto all = bytes(column);
  return {reinterpret_cast<const char*>(all.data()), all.size()};
}

std::span<const std::byte> as_bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

}  // namespace sightline::server::store
