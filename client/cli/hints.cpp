// Tells by codes and reasons, and compares words with those that there are.
#include "client/cli/hints.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string_view>
#include <vector>

#include "client/cli/session.h"
#include "client/cli/suggest.h"

namespace sightline::client::cli {
namespace {

constexpr double kSecondsForNames = 2;

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

std::string did_you_mean(const std::string& word) {
  return word.empty() ? "" : fmt::format("did you mean {}?", word);
}

// The name of a scene in the message, which is its only word of this form.
std::string scene_in(const std::string& message) {
  const std::size_t begin = message.find("projects/");
  if (begin == std::string::npos) return {};
  const std::size_t end = message.find_first_of(" ,;:\"'", begin);
  return message.substr(begin, end == std::string::npos ? end : end - begin);
}

std::string hint_of_scene(const Session& session, const Error& error) {
  const std::string scene = scene_in(error.message);
  const std::size_t middle = scene.find("/scenes/");
  if (middle == std::string::npos) return {};
  Session brief = session;
  brief.deadline = kSecondsForNames;
  const auto client = brief.connect();
  if (!client) return {};
  const auto scenes = client->list_scenes(scene.substr(0, middle));
  if (!scenes) return {};
  std::vector<std::string> names;
  for (const SceneInfo& info : *scenes) names.push_back(info.name.substr(middle + 8));
  const std::string best = nearest(scene.substr(middle + 8), names);
  if (!best.empty()) return did_you_mean(best);
  return names.empty() ? "the server has no scenes" : "`sightline scene ls` lists what there is";
}

std::string hint_of_connection(const Session& session, const Error& error) {
  if (contains(error.message, "refused") || contains(error.message, "No such file"))
    return fmt::format("is sightlined running at {}?", session.endpoint);
  if (contains(error.message, "DNS resolution failed"))
    return fmt::format("is there a machine of that name? ({})", session.endpoint);
  const bool is_other = contains(error.message, "Socket closed") ||
                        contains(error.message, "reset") || contains(error.message, "http1.x") ||
                        contains(error.message, "Failed parsing HTTP/2");
  if (is_other)
    return fmt::format("is {} the port of sightlined? If it encrypts, give --tls-ca",
                       session.endpoint);
  return {};
}

// The deepest verb that was read, after those above it.
std::vector<const CLI::App*> verbs_read(const CLI::App& program) {
  std::vector<const CLI::App*> verbs{&program};
  while (!verbs.back()->get_subcommands().empty())
    verbs.push_back(verbs.back()->get_subcommands().front());
  return verbs;
}

std::vector<std::string> names_of_verbs(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(verb->get_name());
  return names;
}

// The path of a verb of this name below another verb, such as "scene import"; empty: there is none.
std::string verb_below(const CLI::App& program, const std::string& word) {
  for (const CLI::App* group : program.get_subcommands([](const CLI::App*) { return true; })) {
    for (const std::string& name : names_of_verbs(*group)) {
      if (name == word) return group->get_name() + " " + name;
    }
  }
  return {};
}

UsageError unknown_flag(const CLI::App& program, const std::string& word) {
  const std::string flag = word.substr(0, word.find('='));
  std::vector<std::string> flags;
  for (const CLI::App* app : verbs_read(program)) {
    for (const CLI::Option* option : app->get_options()) {
      for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
    }
  }
  const CLI::App& verb = *verbs_read(program).back();
  return {fmt::format("{} has no flag {}", verb.get_display_name(), flag),
          did_you_mean(nearest(flag, flags))};
}

UsageError unknown_word(const CLI::App& program, const std::string& word) {
  const auto verbs = verbs_read(program);
  const CLI::App& last = *verbs.back();
  const auto names = names_of_verbs(last);
  if (verbs.size() > 1 && names.empty()) {
    std::string path = program.get_name();
    for (std::size_t i = 1; i < verbs.size(); ++i) path += " " + verbs[i]->get_name();
    const bool lacks_scene = [&] {
      const CLI::Option* const scene = last.get_option_no_throw("SCENE");
      return scene != nullptr && scene->count() == 0;
    }();
    return {fmt::format("'{}' is one word too many", word),
            lacks_scene ? did_you_mean(path + " " + word) : ""};
  }
  std::string meant = nearest(word, names);
  if (const std::string below = verb_below(program, word); !below.empty()) meant = below;
  return {fmt::format("there is no verb '{}'", word), did_you_mean(meant)};
}

// "--mode: hot not in {depth,heat}" as CLI11 says it.
UsageError wrong_choice(const std::string& text) {
  constexpr std::string_view kBetween = " not in {";
  const std::size_t colon = text.find(": "), between = text.find(kBetween);
  if (colon == std::string::npos || between == std::string::npos || colon > between)
    return {text, {}};
  const std::string word = text.substr(colon + 2, between - colon - 2);
  std::string list = text.substr(between + kBetween.size());
  list.resize(list.find('}') == std::string::npos ? list.size() : list.find('}'));
  const std::vector<std::string> choices = CLI::detail::split(list, ',');
  return {fmt::format("{} is '{}', not one of {}", text.substr(0, colon), word,
                      fmt::join(choices, " ")),
          did_you_mean(nearest(word, choices))};
}

}  // namespace

std::string hint_for(const Session& session, const Error& error) {
  if (error.reason == "SCENE_NOT_FOUND") return hint_of_scene(session, error);
  if (error.reason == "NODE_NOT_FOUND") return "`sightline scene nodes SCENE` lists them";
  if (error.reason == "TOKEN_MISSING") return "give --token-file, or set SIGHTLINE_TOKEN";
  if (error.code == Code::kUnavailable) return hint_of_connection(session, error);
  if (error.code == Code::kUnimplemented) return "the server may be older than this command";
  if (error.code == Code::kDeadlineExceeded)
    return session.deadline ? "--deadline allows more" : "";
  return {};
}

UsageError usage_error_of(const CLI::App& program, const CLI::ParseError& error) {
  const std::string text = error.what();
  const auto kind = static_cast<CLI::ExitCodes>(error.get_exit_code());
  const auto rest = program.remaining(true);
  if ((kind == CLI::ExitCodes::ExtrasError || kind == CLI::ExitCodes::RequiredError) &&
      !rest.empty()) {
    const std::string& word = rest.front();
    return word.starts_with("-") ? unknown_flag(program, word) : unknown_word(program, word);
  }
  if (kind != CLI::ExitCodes::RequiredError) return wrong_choice(text);
  return {text, fmt::format("`{} --help` tells how", [&] {
            std::string path;
            for (const CLI::App* verb : verbs_read(program))
              path += (path.empty() ? "" : " ") + verb->get_name();
            return path;
          }())};
}

}  // namespace sightline::client::cli
