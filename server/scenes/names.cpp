// Names of scenes, projects/{project}/scenes/{scene}, and tokens of their revisions.
#include "server/scenes/names.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <random>

#include "server/exec/rpc_status.h"

namespace sightline::server::scenes {
namespace {

constexpr std::string_view kProjects = "projects/";
constexpr std::string_view kScenes = "/scenes/";

Error bad_name(std::string_view name, std::string_view shape) {
  return {Code::kInvalidArgument,
          fmt::format("{} is not a name of the form {}", exec::quote(name), shape),
          "BAD_RESOURCE_NAME"};
}

/// Whether the text matches [a-z0-9][a-z0-9._-]{0,62}.
bool is_id(std::string_view text) {
  const auto alphanumeric = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  return !text.empty() && text.size() <= kMaxId && alphanumeric(text.front()) &&
         std::all_of(text.begin(), text.end(),
                     [&](char c) { return alphanumeric(c) || c == '.' || c == '_' || c == '-'; });
}

Status check_id(std::string_view what, std::string_view id) {
  if (is_id(id)) return {};
  return Error{
      Code::kInvalidArgument,
      fmt::format("{} id {} does not match [a-z0-9][a-z0-9._-]{{0,62}}", what, exec::quote(id)),
      "BAD_RESOURCE_NAME"};
}

constexpr std::size_t kIncarnationDigits = 16;

bool parse_number(std::string_view digits, int base, std::uint64_t& number) {
  const char* const end = digits.data() + digits.size();
  const auto [stopped, error] = std::from_chars(digits.data(), end, number, base);
  return error == std::errc() && stopped == end;
}

}  // namespace

Status check_scene_name(std::string_view name) {
  const std::size_t scenes = name.find(kScenes);
  if (!name.starts_with(kProjects) || scenes == std::string_view::npos ||
      scenes < kProjects.size()) {
    return bad_name(name, "projects/{project}/scenes/{scene}");
  }
  if (Status project = check_project_name(name.substr(0, scenes)); !project) return project;
  return check_id("scene", name.substr(scenes + kScenes.size()));
}

Status check_project_name(std::string_view name) {
  if (!name.starts_with(kProjects)) return bad_name(name, "projects/{project}");
  return check_id("project", name.substr(kProjects.size()));
}

std::string_view project_of(std::string_view scene_name) {
  return scene_name.substr(0, scene_name.find(kScenes));
}

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
