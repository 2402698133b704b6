// sightline completion: a script that a shell reads.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <memory>
#include <string>

#include "client/cli/reference/completion.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

using Writer = std::string (*)(std::span<const reference::Verb>);

const std::map<std::string, Writer> kShells{{"bash", reference::bash_completion},
                                            {"zsh", reference::zsh_completion},
                                            {"fish", reference::fish_completion}};

ExitCode print_script(const CLI::App& program, const std::string& shell) {
  const std::string script = kShells.at(shell)(reference::verbs_of(program));
  const bool written = std::fwrite(script.data(), 1, script.size(), stdout) == script.size() &&
                       std::fflush(stdout) == 0;
  return written ? kOk : fail(local_error("standard output cannot be written"));
}

}  // namespace

void add_completion_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("completion", "Print a completion script for a shell");
  const auto shell = std::make_shared<std::string>();
  verb.add_option("SHELL", *shell, "The shell that reads the script")
      ->required()
      ->check(CLI::IsMember(kShells).description(""))
      ->type_name("bash|zsh|fish");
  verb.footer(
      "Verbs, options, their values, files and scenes are completed; scenes are asked of the "
      "server.\nPackages install the scripts for all users.\n\n"
      "Examples:\n"
      "  sightline completion bash > ~/.local/share/bash-completion/completions/sightline\n"
      "  sightline completion zsh > ~/.zfunc/_sightline\n"
      "  sightline completion fish > ~/.config/fish/completions/sightline.fish");
  verb.callback([&program, &session, shell] { session.exit = print_script(program, *shell); });
}

}  // namespace sightline::client::cli::verbs
