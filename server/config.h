// The settings of a server, and the flags of sightlined that set them.
#pragma once

#include <spdlog/common.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "proto/result.h"
#include "scenegraph/trace.h"
#include "server/exec/admission.h"
#include "server/exec/quotas.h"
#include "server/security/certificates.h"
#include "server/segments/offer.h"

namespace sightline::server {

/// The settings of a server.
struct ServerConfig {
  std::string listen = "127.0.0.1:50151";  ///< HOST:PORT, where port 0 picks one, or unix:PATH.
  bool insecure = false;            ///< Allow an address that other machines can reach without TLS.
  security::CertificateFiles tls;   ///< Empty: no TLS.
  std::filesystem::path tokens;     ///< Who may do what (security/tokens.h). Empty: everyone all.
  std::filesystem::path port_file;  ///< Gets the bound port once the server is ready. Empty: none.
  std::filesystem::path data_dir;   ///< Created if missing. Empty: none.
  std::string store;  ///< postgresql://..., instead of data_dir; may hold a password. Empty: none.
  std::filesystem::path mesh_cache;  ///< Copies of meshes of `store`. Empty: a temporary directory.
  /// Reads that name no revision are refused when the newest revisions in `store` were last learned
  /// longer ago. 0: never.
  std::chrono::milliseconds max_staleness{0};
  std::string shard_peers;  ///< HOST:PORT,HOST:PORT...: who answers for the shards. Empty: none.
  std::filesystem::path shard_ca;   ///< Their authority. Empty: no TLS, or the system's.
  int threads = default_threads();  ///< Workers for queries, 1 to kMaxThreads. Updates and
                                    ///< background work have as many each.
  scenegraph::Growth policy = scenegraph::Growth::kFirstTouch;  ///< kFirstTouch, kDemand or kFull.
  std::uint64_t memory_budget = default_memory_budget();        ///< Bytes of all that is held.
  exec::AdmissionLimits admission;
  int max_prefetches = 4;  ///< Prefetches at a time, 0 to kMaxPrefetches.
  exec::QuotaConfig quotas;
  segments::Offer segments = segments::Offer::kUnix;  ///< With `shard_peers` none are offered.
  std::string admin;        ///< HOST:PORT for probes, metrics and the live page. Empty: none.
  bool json_calls = false;  ///< Unary calls in JSON, at `admin`.
  bool metrics_per_scene = false;              ///< Metrics with a label for the scene.
  std::chrono::milliseconds slow_query{1000};  ///< Slower ones are logged. 0: none.
  /// A connection of this age is asked to end, and ended kConnectionGrace later. 0: none.
  std::chrono::seconds max_connection_age{0};
  std::chrono::milliseconds not_ready{0};  ///< How long drain() only says that it will.
  std::chrono::milliseconds drain =
      std::chrono::seconds(5);  ///< How long drain() waits for open calls before it cancels them.

  static constexpr int kMaxThreads = 1024;
  static constexpr int kMaxPrefetches = 64;
  static constexpr std::chrono::hours kMaxTime{24};  ///< The limit of every setting that is a time.
  static constexpr std::chrono::minutes kConnectionGrace{1};
  static constexpr int kMaxCallsPerConnection = 64;  ///< Calls at a time; more wait.
  static constexpr int kMaxMessageBytes = 4 << 20;   ///< Largest message that a client may send.
  /// Whether scenes outlive the process.
  bool is_durable() const { return !data_dir.empty() || !store.empty(); }
  static int default_threads();
  /// Half of the memory that this process may use.
  static std::uint64_t default_memory_budget();
};

/// The name of the policy on the command line.
std::string policy_name(scenegraph::Growth policy);

/// What the settings of sightlined set: flags, else the environment, else the file of --config.
struct CommandLine {
  ServerConfig config;
  spdlog::level::level_enum log_level = spdlog::level::info;
  bool check_only = false;         ///< --check-config: only Server::check() is wanted.
  std::vector<std::string> notes;  ///< What is odd about the settings, for the log.
};

inline constexpr int kUsageExit = 2;  ///< Exit code after a usage error.

/// Parses the flags, and reads the environment and the file of settings. Returns an exit code
/// instead if the program must end: 0 after --help, --version and --print-config, kUsageExit after
/// a usage error. The text is then already printed.
std::variant<CommandLine, int> parse_command_line(int argc, const char* const* argv);

}  // namespace sightline::server
