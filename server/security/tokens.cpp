// The tokens that a server accepts, and what each may do.
#include "server/security/tokens.h"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/sha.h>

#include <toml++/toml.h>
#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "server/exec/rpc_status.h"

namespace sightline::server::security {
namespace {

using exec::quote;

constexpr std::string_view kProjects = "projects/";

Error bad(const toml::node& node, const std::string& what) {
  return {Code::kInvalidArgument, fmt::format("line {}: {}", node.source().begin.line, what),
          "BAD_TOKENS"};
}

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= Tokens::kMaxNameBytes &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '.' || c == '_' || c == '-';
         });
}

std::optional<TokenHash> parse_hash(std::string_view text) {
  TokenHash hash{};
  if (text.size() != 2 * hash.size()) return {};
  for (std::size_t i = 0; i < hash.size(); ++i) {
    const char* const digits = text.data() + 2 * i;
    const auto [end, error] = std::from_chars(digits, digits + 2, hash[i], 16);
    if (error != std::errc() || end != digits + 2) return {};
  }
  return hash;
}

std::optional<exec::Role> parse_role(std::string_view text) {
  for (const exec::Role role : {exec::Role::kRead, exec::Role::kWrite, exec::Role::kAdmin}) {
    if (text == exec::role_name(role)) return role;
  }
  return {};
}

/// The prefix with its whole project, so that it does not cover another project.
std::string full_prefix(std::string_view text) {
  if (text.empty() || text == kProjects) return std::string(text);
  if (!text.starts_with(kProjects)) return fmt::format("projects/default/scenes/{}", text);
  const bool ends_in_project = text.find('/', kProjects.size()) == std::string_view::npos;
  return fmt::format("{}{}", text, ends_in_project ? "/" : "");
}

Result<std::string_view> text_of(const toml::table& table, std::string_view key) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return bad(table, fmt::format("a token has no {}", key));
  const auto text = node->value_exact<std::string_view>();
  if (!text) return bad(*node, fmt::format("{} is not a string", key));
  return *text;
}

Result<std::vector<std::string>> prefixes_of(const toml::table& table) {
  const toml::node* node = table.get("scenes");
  const toml::array* array = node != nullptr ? node->as_array() : nullptr;
  if (array == nullptr || array->empty())
    return bad(table, "a token needs scenes, a list of prefixes; [\"\"] stands for all scenes");
  std::vector<std::string> prefixes;
  for (const toml::node& element : *array) {
    const auto text = element.value_exact<std::string_view>();
    if (!text) return bad(element, "a prefix of scenes is not a string");
    prefixes.push_back(full_prefix(*text));
  }
  return prefixes;
}

Status check_keys(const toml::table& table, std::initializer_list<std::string_view> known) {
  for (const auto& [key, value] : table) {
    if (std::find(known.begin(), known.end(), key.str()) == known.end())
      return bad(value, fmt::format("{} is no known key", quote(key.str())));
  }
  return {};
}

struct Row {
  TokenHash hash{};
  std::string name;
  exec::Grant grant;
};

Result<Row> parse_row(const toml::node& node) {
  const toml::table* table = node.as_table();
  if (table == nullptr) return bad(node, "a token is not a table");
  if (const Status known = check_keys(*table, {"name", "sha256", "role", "scenes"}); !known)
    return known.error();
  const auto name = text_of(*table, "name");
  if (!name) return name.error();
  if (!is_name(*name))
    return bad(node, fmt::format("name {} does not match [A-Za-z0-9._-]{{1,{}}}", quote(*name),
                                 Tokens::kMaxNameBytes));
  // What stands here may be a token by mistake: it is not quoted.
  const auto digits = text_of(*table, "sha256");
  if (!digits) return digits.error();
  const auto hash = parse_hash(*digits);
  if (!hash) return bad(node, fmt::format("sha256 of {} is not 64 hex digits", quote(*name)));
  const auto role_text = text_of(*table, "role");
  if (!role_text) return role_text.error();
  const auto role = parse_role(*role_text);
  if (!role)
    return bad(node, fmt::format("role {} is not read, write or admin", quote(*role_text)));
  auto prefixes = prefixes_of(*table);
  if (!prefixes) return prefixes.error();
  return Row{*hash, std::string(*name), {*role, *std::move(prefixes)}};
}

}  // namespace

Result<Tokens> Tokens::parse(std::string_view toml) try {
  const toml::table file = toml::parse(toml);
  if (const Status known = check_keys(file, {"token"}); !known) return known.error();
  const toml::array* tables = file["token"].as_array();
  if (tables == nullptr || tables->empty()) return bad(file, "there is no [[token]]");
  if (tables->size() > kMaxTokens) {
    return bad(file,
               fmt::format("there are {} tokens, the limit is {}", tables->size(), kMaxTokens));
  }
  std::map<TokenHash, exec::Principal> by_hash;
  for (const toml::node& node : *tables) {
    auto row = parse_row(node);
    if (!row) return row.error();
    exec::Principal& principal = by_hash[row->hash];
    if (!principal.name.empty() && principal.name != row->name) {
      return bad(node,
                 fmt::format("{} and {} have one sha256", quote(principal.name), quote(row->name)));
    }
    principal.name = row->name;
    principal.grants.push_back(std::move(row->grant));
  }
  Tokens tokens;
  for (auto& [hash, principal] : by_hash) {
    tokens.entries_.push_back(
        {hash, std::make_shared<const exec::Principal>(std::move(principal))});
  }
  return tokens;
} catch (const toml::parse_error& error) {
  return Error{Code::kInvalidArgument,
               fmt::format("line {}: {}", error.source().begin.line, error.description()),
               "BAD_TOKENS"};
}

std::shared_ptr<const exec::Principal> Tokens::find(std::string_view token) const {
  TokenHash hash{};
  SHA256(reinterpret_cast<const unsigned char*>(token.data()), token.size(), hash.data());
  const Entry* found = nullptr;
  for (const Entry& entry : entries_) {
    if (CRYPTO_memcmp(entry.hash.data(), hash.data(), hash.size()) == 0) found = &entry;
  }
  return found != nullptr ? found->principal : nullptr;
}

void Tokens::keep_equal(const Tokens& old) {
  for (Entry& entry : entries_) {
    for (const Entry& before : old.entries_) {
      if (entry.hash == before.hash && *entry.principal == *before.principal)
        entry.principal = before.principal;
    }
  }
}

}  // namespace sightline::server::security
