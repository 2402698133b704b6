// The content of SceneRevision.token.
#include "server/scenes/revision_token.h"

#include <fmt/format.h>

#include <charconv>
#include <random>

#include "server/exec/rpc_status.h"

namespace sightline::server::scenes {
namespace {

constexpr std::size_t kIncarnationDigits = 16;

bool parse_number(std::string_view digits, int base, std::uint64_t& number) {
  const char* const end = digits.data() + digits.size();
  const auto [stopped, error] = std::from_chars(digits.data(), end, number, base);
  return error == std::errc() && stopped == end;
}

}  // namespace

std::string RevisionToken::text() const { return fmt::format("{:016x}-{}", incarnation, revision); }

Result<RevisionToken> RevisionToken::parse(std::string_view text) {
  RevisionToken token;
  const bool shaped = text.size() > kIncarnationDigits + 1 && text[kIncarnationDigits] == '-';
  if (shaped && parse_number(text.substr(0, kIncarnationDigits), 16, token.incarnation) &&
      parse_number(text.substr(kIncarnationDigits + 1), 10, token.revision)) {
    return token;
  }
  return Error{Code::kInvalidArgument, fmt::format("{} is not a revision token", exec::quote(text)),
               "BAD_TOKEN"};
}

std::uint64_t new_incarnation() {
  std::random_device random;
  return std::uniform_int_distribution<std::uint64_t>()(random);
}

void encode_revision(const RevisionToken& token, v1::SceneRevision& out) {
  out.set_revision(token.revision);
  out.set_token(token.text());
}

}  // namespace sightline::server::scenes
