// Reads options, arguments and verbs out of the parser.
#include "client/cli/reference/verb.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <set>
#include <string_view>

namespace sightline::client::cli::reference {
namespace {

/// The words of y|z; none if it is no such list. In HOST:PORT|unix:PATH capitals stand for text.
std::vector<std::string> choices_of(std::string_view label) {
  const auto is_plain = [](char c) { return std::islower(c) || std::isdigit(c) || c == '-'; };
  std::vector<std::string> words(1);
  for (const char c : label) {
    if (c == '|') {
      words.emplace_back();
    } else if (is_plain(c)) {
      words.back() += c;
    } else {
      return {};
    }
  }
  if (words.size() < 2) return {};
  return words;
}

Value value_of(const std::string& label, const std::string& name) {
  const auto choices = choices_of(label);
  if (!choices.empty()) return {Value::Kind::kChoices, choices};
  for (const std::string& word : {label, name}) {
    if (word == "FILE" || word == "FILE|DIR") return {Value::Kind::kFile, {}};
    if (word == "DIR") return {Value::Kind::kDirectory, {}};
    if (word == "SCENE") return {Value::Kind::kScene, {}};
  }
  return {Value::Kind::kText, {}};
}

std::string names_of(const std::set<CLI::Option*>& options) {
  std::string text;
  for (const CLI::Option* option : options) text += (text.empty() ? "" : ", ") + option->get_name();
  return text;
}

std::string help_of(const CLI::Option& option) {
  std::string text = option.get_description();
  const auto append = [&text](const std::string& what, const std::string& value) {
    if (!value.empty()) text += ". " + what + ": " + value;
  };
  append("Default", option.get_default_str());
  append("Environment", option.get_envname());
  append("Needs", names_of(option.get_needs()));
  append("Excludes", names_of(option.get_excludes()));
  return text;
}

Option option_of(const CLI::Option& option) {
  Option made{.help = help_of(option),
              .required = option.get_required(),
              .repeated = option.get_items_expected_max() > 1};
  const bool is_flag = option.get_items_expected_max() == 0;
  if (!is_flag) made.label = option.get_type_name();
  if (option.get_positional()) {
    made.names = {option.get_name()};
  } else {
    for (const std::string& name : option.get_snames()) made.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) made.names.push_back("--" + name);
  }
  if (!is_flag) made.value = value_of(made.label, made.names.front());
  return made;
}

void append_verbs(const CLI::App& app, const std::string& path, std::vector<Verb>& verbs) {
  Verb verb{.path = path, .summary = app.get_description(), .details = app.get_footer()};
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    (option->get_positional() ? verb.arguments : verb.options).push_back(option_of(*option));
  }
  const auto below = app.get_subcommands([](const CLI::App*) { return true; });
  for (const CLI::App* one : below) verb.verbs.push_back(one->get_name());
  verbs.push_back(std::move(verb));
  for (const CLI::App* one : below) append_verbs(*one, join_path(path, one->get_name()), verbs);
}

}  // namespace

std::vector<Verb> verbs_of(const CLI::App& program) {
  std::vector<Verb> verbs;
  append_verbs(program, "", verbs);
  return verbs;
}

std::string name_of(const Verb& verb) {
  const std::size_t blank = verb.path.rfind(' ');
  return blank == std::string::npos ? verb.path : verb.path.substr(blank + 1);
}

std::string join_path(const std::string& path, const std::string& name) {
  return path.empty() ? name : path + " " + name;
}

}  // namespace sightline::client::cli::reference
