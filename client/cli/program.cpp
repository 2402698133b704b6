// Adds the flags of the whole command and handles their errors.
#include "client/cli/program.h"

#include <stdlib.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/cli/flags.h"
#include "client/cli/hints.h"
#include "client/cli/reporting.h"
#include "client/cli/session.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/rtrace_flags.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli {
namespace {

constexpr const char* kFooter = R"(Flags of the program may stand before the verb or after it.

Exit codes: 0 ok, 1 failed, 2 usage, 3 scene or node not known to the server, 4 conflict, 5 unavailable or out of time,
6 not allowed, 7 over a limit, 130 interrupted, 143 terminated.

Examples:
  sightline scene import engine 2CylinderEngine.glb
  echo 0 500 0 0 -1 0 | sightline cast engine
  sightline cast engine --in rays.npy --out hits.npy
  sightline prefetch engine --rays rays.npy
  sightline render engine --out engine.png
  sightline stats engine --json
  sightline stream robot --animate robot.glb)";

void add_security_flags(CLI::App& program, Session& session) {
  CLI::Option* const authority =
      program.add_option("--tls-ca", session.options.tls_ca,
                         "Encrypt; the server needs a certificate that one of these has signed");
  CLI::Option* const certificate =
      program.add_option("--tls-cert", session.options.tls_cert, "Certificate of this client")
          ->needs(authority);
  CLI::Option* const key =
      program.add_option("--tls-key", session.options.tls_key, "Private key of the certificate")
          ->needs(certificate);
  certificate->needs(key);
  CLI::Option* const token =
      program.add_option("--token-file", session.token_file,
                         "File of the token that the server knows this client by (default: the "
                         "token in SIGHTLINE_TOKEN)");
  for (CLI::Option* const file : {authority, certificate, key, token}) file->type_name("FILE");
}

void add_global_flags(CLI::App& program, Session& session) {
  program.set_version_flag("--version", "sightline " SIGHTLINE_VERSION);
  program.add_option("--endpoint", session.endpoint, "Where the server listens")
      ->envname("SIGHTLINE_ENDPOINT")
      ->type_name("HOST:PORT[,HOST:PORT...]|unix:PATH")
      ->capture_default_str()
      ->check(CLI::Validator(
          [](std::string& text) -> std::string {
            const auto client = Client::connect(text);
            return client ? "" : client.error().message;
          },
          ""));
  add_security_flags(program, session);
  program.add_flag("--json", session.json,
                   "Print one JSON document; errors are JSON on standard error");
  program.add_flag("-q,--quiet", session.quiet, "No progress, no summaries and no warnings");
  program
      .add_option("--deadline", session.deadline, "Give up a call to the server after this long")
      ->check(positive_number())
      ->type_name("SECONDS");
}

// How errors are told is needed before the flags are read: they may be wrong.
bool has_word(int argc, const char* const* argv, std::initializer_list<std::string_view> words) {
  return std::any_of(argv, argv + argc, [&](const char* argument) {
    return std::find(words.begin(), words.end(), argument) != words.end();
  });
}

/// The words of a command, quoted where a shell needs it.
std::string command_line(int argc, const char* const* argv) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:=,@%+";
  std::string text = "sightline";
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    text += ' ';
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos) {
      text += word;
      continue;
    }
    text += '\'';
    for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    text += '\'';
  }
  return text;
}

}  // namespace

std::unique_ptr<CLI::App> make_program(Session& session) {
  auto made =
      std::make_unique<CLI::App>("Ray queries on scenes of a Sightline server", "sightline");
  CLI::App& program = *made;
  program.fallthrough();
  require_verb(program);
  program.footer(kFooter);
  add_global_flags(program, session);
  verbs::add_scene_verbs(program, session);
  verbs::add_cast_verb(program, session);
  verbs::add_nearest_verb(program, session);
  verbs::add_rtrace_verb(program, session);
  verbs::add_prefetch_verb(program, session);
  verbs::add_render_verb(program, session);
  verbs::add_slice_verb(program, session);
  verbs::add_stats_verb(program, session);
  verbs::add_update_verb(program, session);
  verbs::add_stream_verb(program, session);
  verbs::add_watch_verb(program, session);
  verbs::add_load_verb(program, session);
  verbs::add_backup_verbs(program, session);
  verbs::add_server_verb(program, session);
  verbs::add_completion_verb(program, session);
  return made;
}

namespace {

int parse_and_run(int argc, const char* const* argv) {
  Session session;
  session.command = command_line(argc, argv);
  const auto program = make_program(session);
  const ReportingScope reporting(
      {.json = has_word(argc, argv, {"--json"}),
       .quiet = has_word(argc, argv, {"-q", "--quiet"}),
       .hint = [&session](const Error& error) { return hint_for(session, error); }});
  try {
    std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    verbs::spell_out_rtrace_flags(words);
    std::reverse(words.begin(), words.end());  // as the parser wants them
    program->parse(std::move(words));
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return program->exit(e);
    const UsageError wrong = usage_error_of(*program, e);
    print_usage_error(wrong.message, wrong.hint, kUsage);
    return kUsage;
  }
  return session.exit;
}

}  // namespace

int run_program(int argc, const char* const* argv) {
  // The errors of calls say what gRPC would log.
  ::setenv("GRPC_VERBOSITY", "NONE", 0);  // NOLINT(concurrency-mt-unsafe): no other thread yet
  try {
    return parse_and_run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "sightline: %s\n", printable(e.what()).c_str());
    return kFailed;
  }
}

}  // namespace sightline::client::cli
