// The settings of a server, and the flags of sightlined that set them.
#include "server/config.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <utility>

#include "server/describe.h"
#include "server/exec/rpc_status.h"
#include "server/net/listen_address.h"
#include "server/settings/byte_size.h"
#include "server/settings/quota_settings.h"
#include "server/settings/settings_file.h"
#include "server/settings/sources.h"
#include "server/store/postgres/address.h"

namespace sightline::server {
namespace {

const std::map<std::string, scenegraph::Growth> kPolicies{
    {"first-touch", scenegraph::Growth::kFirstTouch},
    {"demand", scenegraph::Growth::kDemand},
    {"full", scenegraph::Growth::kFull}};

const std::map<std::string, segments::Offer> kOffers{{"off", segments::Offer::kOff},
                                                     {"unix", segments::Offer::kUnix},
                                                     {"local", segments::Offer::kLocal}};

const std::map<std::string, spdlog::level::level_enum> kLogLevels{{"trace", spdlog::level::trace},
                                                                  {"debug", spdlog::level::debug},
                                                                  {"info", spdlog::level::info},
                                                                  {"warn", spdlog::level::warn},
                                                                  {"error", spdlog::level::err}};

std::string check_address(const std::string& text) {
  const auto address = net::ListenAddress::parse(text);
  return address.ok() ? std::string() : address.error().message;
}

/// CLI11's own checks compare in double and take -1 for a large number.
std::string check_count(const std::string& text) {
  std::uint64_t count = 0;
  const char* end = text.data() + text.size();
  const auto [parsed_to, error] = std::from_chars(text.data(), end, count);
  const bool good = error == std::errc{} && parsed_to == end && count > 0;
  return good ? std::string() : exec::quote(text) + " is not a whole number of at least 1";
}

/// CLI11's own transformer also takes the enumerators' numbers, and its errors list them.
template <class Value>
void add_choice(CLI::App& app, const std::string& flag, const std::map<std::string, Value>& choices,
                Value& value, const std::string& fallback, const std::string& help) {
  app.add_option_function<std::string>(
         flag, [&choices, &value](const std::string& name) { value = choices.at(name); }, help)
      ->check(CLI::IsMember(choices))
      ->default_str(fallback);
}

void add_security_flags(CLI::App& app, ServerConfig& config) {
  app.add_flag("--insecure", config.insecure,
               "Allow an address that other machines can reach without TLS");
  app.add_option(
      "--tls-cert", config.tls.certificate,
      "Certificate of the server, then those of its issuers (PEM); read again when it changes");
  app.add_option("--tls-key", config.tls.key, "Private key of the certificate (PEM)");
  app.add_option("--tls-client-ca", config.tls.client_ca,
                 "Clients need a certificate that one of these has signed (PEM)");
  app.add_option("--tokens", config.tokens,
                 "Clients need a token of which this TOML file has the hash; read again when it "
                 "changes");
}

/// A flag for a number of bytes, of at least 1.
void add_bytes(CLI::App& app, const std::string& flag, std::uint64_t& bytes,
               const std::string& help) {
  const auto check = [](const std::string& text) {
    const auto size = settings::parse_byte_size(text, 1);
    return size ? std::string() : size.error().message;
  };
  app.add_option_function<std::string>(
         flag, [&bytes](const std::string& text) { bytes = *settings::parse_byte_size(text, 1); },
         help)
      ->check(CLI::Validator(check, ""))
      ->type_name("SIZE")
      ->default_str(std::to_string(bytes));
}

/// A flag for a time in whole units of Duration.
template <class Duration>
void add_time(CLI::App& app, const std::string& flag, Duration& time, const std::string& help) {
  const Duration most = ServerConfig::kMaxTime;
  app.add_option_function<std::int64_t>(
         flag, [&time](const std::int64_t& count) { time = Duration(count); }, help)
      ->check(CLI::Range(std::int64_t{0}, static_cast<std::int64_t>(most.count())))
      ->default_str(std::to_string(time.count()));
}

void add_operations_flags(CLI::App& app, ServerConfig& config) {
  app.add_option(
         "--admin", config.admin,
         "HOST:PORT or unix:PATH of /livez, /readyz and /metrics over HTTP; port 0 picks one")
      ->check(CLI::Validator(check_address, "HOST:PORT"));
  app.add_flag("--json-calls", config.json_calls,
               "Answer POST /v1/json/CALL at --admin: unary calls in JSON, with the same tokens");
  app.add_flag("--metrics-per-scene", config.metrics_per_scene,
               "Metrics with a label for each scene");
  add_time(app, "--slow-query-ms", config.slow_query,
           "Log queries that take this long, with what they built; 0: none");
  add_time(app, "--max-connection-age-s", config.max_connection_age,
           "Seconds after which a connection is asked to end, so that clients rebalance; 0: none");
  add_time(app, "--not-ready-ms", config.not_ready,
           "After SIGTERM: how long to serve on while /readyz says no");
  add_time(app, "--drain-ms", config.drain, "After that: how long open calls may go on");
}

/// What the program is asked for instead of serving.
struct Requests {
  std::string file;
  bool print = false;
};

void add_requests(CLI::App& app, CommandLine& line, Requests& requests) {
  app.add_option("--config", requests.file, "TOML file of settings, named as the flags")
      ->configurable(false);
  app.add_flag("--check-config", line.check_only, "Check the settings and exit")
      ->configurable(false);
  app.add_flag("--print-config", requests.print,
               "Print the settings as TOML, each with its source, and exit")
      ->configurable(false);
}

void add_storage_flags(CLI::App& app, ServerConfig& config) {
  app.add_option("--data-dir", config.data_dir,
                 "Directory of the server's files; created if missing");
  app.add_option("--store", config.store,
                 "postgresql://USER@HOST:PORT,HOST:PORT/DATABASE, which several servers may share; "
                 "instead of --data-dir")
      ->type_name("URI");
  add_time(
      app, "--max-staleness-ms", config.max_staleness,
      "Refuse reads that name no revision when the store was not reached for longer; 0: never");
  app.add_option("--mesh-cache", config.mesh_cache,
                 "Directory for copies of the store's meshes, of this server alone; by default a "
                 "temporary one");
}

void add_shard_flags(CLI::App& app, ServerConfig& config) {
  app.add_option("--shard-peers", config.shard_peers,
                 "HOST:PORT,HOST:PORT,...: the servers of this --store, this one too, in the same "
                 "order at each; every one answers for a part of each scene")
      ->type_name("PEERS");
  app.add_option("--shard-ca", config.shard_ca,
                 "With --tls-cert: who signs the certificates of --shard-peers (PEM); by default "
                 "whom this machine trusts");
}

void add_flags(CLI::App& app, CommandLine& line) {
  ServerConfig& config = line.config;
  const CLI::Validator count(check_count, "COUNT");
  app.add_option("--listen", config.listen,
                 "HOST:PORT to listen on, where port 0 picks one, or unix:PATH")
      ->check(CLI::Validator(check_address, "HOST:PORT"))
      ->capture_default_str();
  add_security_flags(app, config);
  app.add_option("--port-file", config.port_file,
                 "File to write the bound port to, once ready (0: a Unix socket)");
  add_storage_flags(app, config);
  add_shard_flags(app, config);
  app.add_option("--threads", config.threads,
                 "Threads that trace and build; as many again prefetch, where that is asked for")
      ->check(CLI::Range(1, ServerConfig::kMaxThreads))
      ->capture_default_str();
  add_choice(
      app, "--policy", kPolicies, config.policy, "first-touch",
      "When trees are built: where rays enter, where that pays, or fully before the first ray");
  add_bytes(app, "--memory-budget", config.memory_budget,
            "Bytes to hold at most, such as 4G: meshes, trees, nodes, logs, calls; by default half "
            "of the memory");
  app.add_option("--max-rays-queued", config.admission.rays,
                 "Rays in work at most; more are refused")
      ->check(count)
      ->capture_default_str();
  add_bytes(app, "--max-bytes-queued", config.admission.bytes,
            "Bytes of requests in work at most, such as 256M");
  app.add_option("--max-prefetches", config.max_prefetches,
                 "Prefetches in work at most; more are refused")
      ->check(CLI::Range(0, ServerConfig::kMaxPrefetches))
      ->capture_default_str();
  add_choice(
      app, "--segments", kOffers, config.segments, "unix",
      "Who may share memory with the server: no client, those at its Unix socket, or those at "
      "loopback addresses, too");
  add_choice(app, "--log-level", kLogLevels, line.log_level, "info", "Least level that is logged");
  add_operations_flags(app, config);
  app.set_version_flag("--version", "sightlined " SIGHTLINE_VERSION, "Print the version and exit");
}

}  // namespace

int ServerConfig::default_threads() {
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMaxThreads);
}

std::uint64_t ServerConfig::default_memory_budget() {
  std::uint64_t bytes = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                        static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  std::uint64_t container = 0;  // "max" where there is no limit, which does not parse
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> container) bytes = std::min(bytes, container);
  return bytes / 2;
}

std::string policy_name(scenegraph::Growth policy) {
  for (const auto& [name, growth] : kPolicies) {
    if (growth == policy) return name;
  }
  return {};
}

namespace {

/// The variable that names the file of settings, where no flag does.
constexpr const char* kFileVariable = "SIGHTLINED_CONFIG";

Result<settings::SettingsFile> settings_file(const Requests& requests) {
  if (!requests.file.empty()) return settings::read_settings(requests.file);
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing changes the environment
  const char* named = std::getenv(kFileVariable);
  if (named == nullptr || *named == '\0') return settings::SettingsFile();
  return settings::read_settings(named);
}

/// A setting's value as it may be printed.
std::string show_setting(const std::string& setting, const std::string& value) {
  return setting == "store" ? store::postgres::hide_password(value) : value;
}

/// Sets what no flag has set. Prints the settings if that is requested.
Status complete(CLI::App& app, const Requests& requests, CommandLine& line) {
  const auto file = settings_file(requests);
  if (!file) return file.error();
  const auto sources = settings::set_from_sources(app, *file);
  if (!sources) return sources.error();
  auto quotas = settings::read_quotas(*file);
  if (!quotas) return quotas.error();
  line.config.quotas = std::move(*quotas);
  for (const std::string& variable : settings::unknown_variables(app, environ)) {
    if (variable != kFileVariable)
      line.notes.push_back("the environment variable " + variable + " is no setting");
  }
  if (requests.print) {
    const std::string text =
        settings::print_settings(app, *sources, show_setting) + settings::print_quotas(*file);
    std::fputs(text.c_str(), stdout);
  }
  return {};
}

}  // namespace

namespace {

void add_everything(CLI::App& app, CommandLine& line, Requests& requests) {
  app.description("Answers ray queries against scenes over gRPC");
  app.name("sightlined");
  app.footer("sightlined doctor DIR [--repair] [--accept-loss] examines a data directory.");
  add_flags(app, line);
  add_requests(app, line, requests);
}

}  // namespace

void describe_flags(const std::function<void(const CLI::App&)>& read) {
  CommandLine line;
  Requests requests;
  CLI::App app;
  add_everything(app, line, requests);
  app.get_option("--threads")->default_str("as many as there are processors");
  app.get_option("--memory-budget")->default_str("half of the memory");
  read(app);
}

std::variant<CommandLine, int> parse_command_line(int argc, const char* const* argv) {
  CommandLine line;
  Requests requests;
  CLI::App app;
  add_everything(app, line, requests);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageExit;
  }
  if (const Status completed = complete(app, requests, line); !completed) {
    std::fprintf(stderr, "sightlined: %s\n", completed.error().message.c_str());
    return kUsageExit;
  }
  if (requests.print) return 0;
  return line;
}

}  // namespace sightline::server
