// What the completion scripts offer, asked of the shells themselves where they are installed.
#include "client/cli/reference/completion.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "client/cli/program.h"
#include "client/cli/session.h"
#include "tests/client/support/run_program.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli::reference {
namespace {

using Words = std::set<std::string>;

/// Standard output of a command of /bin/sh. Fails the test unless it exits with 0.
std::string shell(const std::string& command) {
  std::FILE* const pipe = ::popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> part{};
  for (std::size_t n = 1; n > 0;) {
    n = std::fread(part.data(), 1, part.size(), pipe);
    text.append(part.data(), n);
  }
  EXPECT_EQ(::pclose(pipe), 0) << command;
  return text;
}

bool is_installed(const std::string& program) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe,cert-env33-c): a test with one thread
  return std::system(("command -v " + program + " >/dev/null").c_str()) == 0;
}

Words words_of(const std::string& text) {
  std::istringstream stream(text);
  Words words;
  for (std::string word; stream >> word;) words.insert(word);
  return words;
}

class Completion : public testing::Test {
 protected:
  std::string script(const std::string& name) {
    const auto outcome = tests::run_program({"completion", name});
    EXPECT_EQ(outcome.exit, 0) << outcome.err;
    return dir_.write("script." + name, outcome.out);
  }

  /// What bash offers for the last of the words, which are split as bash splits them. The command
  /// itself lists two scenes, of which one would do harm.
  Words bash(const std::string& typed, int count) {
    const std::string run = dir_.write("run.bash", R"(
sightline() { printf 'SCENE\nengine\n$(touch harm)\n'; }
source "$1"
COMP_WORDS=()" + typed + R"()
COMP_CWORD=)" + std::to_string(count) + R"(
_sightline
printf '%s\n' "${COMPREPLY[@]}"
)");
    return words_of(shell("cd " + dir_.path("") + " && bash --norc " + run + " " + script("bash")));
  }

  /// What zsh's functions are given to offer.
  Words zsh(const std::string& typed, const std::string& last, int count) {
    const std::string run = dir_.write("run.zsh", R"(
compdef() { :; }
compset() { :; }
_files() { print "files $*"; }
compadd() { shift; print -l -- "$@"; }
_describe() { local name="${@[-1]}"; print -l -- "${(@P)name%%:*}"; }
sightline() { printf 'SCENE\nengine\n$(touch harm)\n'; }
source "$1"
words=()" + typed + R"()
CURRENT=)" + std::to_string(count) + R"(
PREFIX=)" + last + R"(
_sightline
)");
    return words_of(shell("zsh -f " + run + " " + script("zsh")));
  }

  /// What fish offers, without descriptions: `string replace` fails where there is none.
  Words fish(const std::string& typed) {
    const std::string run = dir_.write("run.fish", R"(
function sightline; printf 'SCENE\nengine\n$(touch harm)\n'; end
source $argv[1]
complete -C ')" + typed + "' | string replace -r '\\t.*' ''\ntrue\n");
    return words_of(shell("fish --no-config " + run + " " + script("fish")));
  }

  tests::TempDir dir_;
};

TEST_F(Completion, KnowsEveryVerbAndOption) {
  Session session;
  const auto verbs = verbs_of(*make_program(session));
  ASSERT_EQ(verbs.front().path, "");
  for (const auto write : {bash_completion, zsh_completion, fish_completion}) {
    const std::string text = write(verbs);
    for (const Verb& verb : verbs) {
      EXPECT_NE(text.find("'" + verb.path + "'"), std::string::npos) << verb.path;
      for (const Option& option : verb.options) {
        const std::string name = option.names.back().substr(option.names.back().rfind('-') + 1);
        EXPECT_NE(text.find(name), std::string::npos) << name;
      }
    }
  }
}

TEST_F(Completion, ReadsValuesOutOfTheOptions) {
  Session session;
  for (const Verb& verb : verbs_of(*make_program(session))) {
    if (verb.path != "cast") continue;
    ASSERT_EQ(verb.arguments.size(), 1u);
    EXPECT_EQ(verb.arguments[0].value.kind, Value::Kind::kScene);
    for (const Option& option : verb.options) {
      if (option.names.back() == "--in") {
        EXPECT_EQ(option.value.kind, Value::Kind::kFile);
      }
      if (option.names.back() == "--build") {
        EXPECT_EQ(option.value.choices, (std::vector<std::string>{"lazy", "full", "none"}));
      }
      if (option.names.back() == "--help") {
        EXPECT_EQ(option.value.kind, Value::Kind::kNone);
      }
    }
  }
}

TEST_F(Completion, AnUnknownShellIsAUsageError) {
  EXPECT_EQ(tests::run_program({"completion", "csh"}).exit, 2);
  EXPECT_EQ(tests::run_program({"completion"}).exit, 2);
}

TEST_F(Completion, Bash) {
  if (!is_installed("bash")) GTEST_SKIP() << "bash is not installed";
  dir_.write("rays.npy", "");
  EXPECT_EQ(bash("sightline ca", 1), Words{"cast"});
  EXPECT_EQ(bash("sightline scene r", 2), Words{"rm"});
  EXPECT_EQ(bash("sightline cast ''", 2), Words{"engine"});
  EXPECT_EQ(bash("sightline --endpoint a : 1 cast --json e", 7), Words{"engine"});
  EXPECT_EQ(bash("sightline cast engine --in ra", 4), Words{"rays.npy"});
  EXPECT_EQ(bash("sightline cast --build ''", 3), (Words{"lazy", "full", "none"}));
  EXPECT_EQ(bash("sightline cast --build =", 3), (Words{"lazy", "full", "none"}));
  EXPECT_EQ(bash("sightline cast --build = f", 4), Words{"full"});
  EXPECT_EQ(bash("sightline cast --max", 2), Words{"--max-hits"});
  EXPECT_EQ(bash("sightline cast --js", 2), Words{"--json"});
  EXPECT_EQ(bash("sightline completion ''", 2), (Words{"bash", "zsh", "fish"}));
}

TEST_F(Completion, Zsh) {
  if (!is_installed("zsh")) GTEST_SKIP() << "zsh is not installed";
  EXPECT_TRUE(zsh("sightline ''", "", 2).contains("cast"));
  EXPECT_EQ(zsh("sightline cast ''", "", 3), Words{"engine"});
  EXPECT_TRUE(zsh("sightline cast --m", "--m", 3).contains("--max-hits"));
  EXPECT_EQ(zsh("sightline cast --build ''", "", 4), (Words{"lazy", "full", "none"}));
  EXPECT_EQ(zsh("sightline cast --in ''", "", 4), Words{"files"});
  EXPECT_EQ(zsh("sightline cast --build=", "--build=", 3), (Words{"lazy", "full", "none"}));
}

TEST_F(Completion, Fish) {
  if (!is_installed("fish")) GTEST_SKIP() << "fish is not installed";
  EXPECT_EQ(fish("sightline ca"), Words{"cast"});
  EXPECT_EQ(fish("sightline scene r"), Words{"rm"});
  EXPECT_EQ(fish("sightline cast "), Words{"engine"});
  EXPECT_EQ(fish("sightline --endpoint a:1 cast --build "), (Words{"lazy", "full", "none"}));
  EXPECT_EQ(fish("sightline cast --max"), Words{"--max-hits"});
  EXPECT_EQ(fish("sightline cast --jso"), Words{"--json"});
}

}  // namespace
}  // namespace sightline::client::cli::reference
