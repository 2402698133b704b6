// The settings of a server, and the flags of sightlined that set them.
#include "server/config.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <thread>

#include "server/exec/rpc_status.h"
#include "server/net/listen_address.h"

namespace sightline::server {
namespace {

const std::map<std::string, scenegraph::Growth> kPolicies{
    {"first-touch", scenegraph::Growth::kFirstTouch}, {"full", scenegraph::Growth::kFull}};

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

void add_flags(CLI::App& app, CommandLine& line) {
  ServerConfig& config = line.config;
  const CLI::Validator count(check_count, "COUNT");
  app.add_option("--listen", config.listen, "HOST:PORT to listen on; port 0 picks one")
      ->check(CLI::Validator(check_address, "HOST:PORT"))
      ->capture_default_str();
  app.add_flag("--insecure", config.insecure, "Allow an address that other machines can reach");
  app.add_option("--port-file", config.port_file, "File to write the bound port to, once ready");
  app.add_option("--data-dir", config.data_dir,
                 "Directory of the server's files; created if missing");
  app.add_option("--threads", config.threads,
                 "Threads that trace and build; as many again prefetch, where that is asked for")
      ->check(CLI::Range(1, ServerConfig::kMaxThreads))
      ->capture_default_str();
  add_choice(app, "--policy", kPolicies, config.policy, "first-touch",
             "When trees are built: where rays enter, or fully before the first ray");
  app.add_option(
         "--memory-budget", config.memory_budget,
         "Bytes to hold at most: meshes, trees, nodes, logs, calls (default: half of the memory)")
      ->check(count);
  app.add_option("--max-rays-queued", config.admission.rays,
                 "Rays in work at most; more are refused")
      ->check(count)
      ->capture_default_str();
  app.add_option("--max-bytes-queued", config.admission.bytes, "Bytes of requests in work at most")
      ->check(count)
      ->capture_default_str();
  app.add_option("--max-prefetches", config.max_prefetches,
                 "Prefetches in work at most; more are refused")
      ->check(CLI::Range(0, ServerConfig::kMaxPrefetches))
      ->capture_default_str();
  add_choice(app, "--log-level", kLogLevels, line.log_level, "info", "Least level that is logged");
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
  return policy == scenegraph::Growth::kFull ? "full" : "first-touch";
}

std::variant<CommandLine, int> parse_command_line(int argc, const char* const* argv) {
  CommandLine line;
  CLI::App app("sightlined: answers ray queries against scenes over gRPC", "sightlined");
  app.footer("sightlined doctor DIR [--repair] examines a data directory.");
  add_flags(app, line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageExit;
  }
  return line;
}

}  // namespace sightline::server
