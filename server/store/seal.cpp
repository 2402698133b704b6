// What ties a row to its place: a sum over all that it says and over whose it is.
#include "server/store/seal.h"

#include <bit>

#include "server/store/checksum.h"
#include "server/store/database.h"

namespace sightline::server::store {

Seal& Seal::add(std::uint64_t number) {
  constexpr unsigned kByte = 8;
  for (unsigned i = 0; i < sizeof(number); ++i)
    text_.push_back(static_cast<char>(number >> (kByte * i)));
  return *this;
}

Seal& Seal::add(double number) { return add(std::bit_cast<std::uint64_t>(number)); }

Seal& Seal::add(std::string_view text) {
  add(std::uint64_t{text.size()});
  text_ += text;
  return *this;
}

std::int64_t Seal::value() const {
  const std::int64_t sum = checksum_of(as_bytes(text_));
  return sum == 0 ? 1 : sum;
}

}  // namespace sightline::server::store
