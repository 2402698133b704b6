// The flags of sightlined, and addresses to listen on.
#include "server/config.h"

#include <gtest/gtest.h>

#include <stdlib.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/server/support/temporary_file.h"

namespace sightline::server {
namespace {

std::variant<CommandLine, int> parse(std::vector<const char*> flags) {
  flags.insert(flags.begin(), "sightlined");
  return parse_command_line(static_cast<int>(flags.size()), flags.data());
}

using tests::TemporaryFile;

/// A variable of the environment while a test runs.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) { setenv(name, value, 1); }
  ~Variable() { unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* const name_;
};

/// The text of a usage error; empty if there is none.
std::string usage_error(const std::vector<const char*>& flags) {
  testing::internal::CaptureStderr();
  const auto line = parse(flags);
  const std::string text = testing::internal::GetCapturedStderr();
  const int* code = std::get_if<int>(&line);
  return code != nullptr && *code == kUsageExit ? text : std::string();
}

TEST(CommandLine, HasTheDocumentedDefaults) {
  const auto line = parse({});
  ASSERT_TRUE(std::holds_alternative<CommandLine>(line));
  const ServerConfig& config = std::get<CommandLine>(line).config;
  EXPECT_EQ(config.listen, "127.0.0.1:50151");
  EXPECT_EQ(config.policy, scenegraph::Growth::kFirstTouch);
  EXPECT_GE(config.threads, 1);
  EXPECT_GT(config.memory_budget, 0u);
  EXPECT_FALSE(config.insecure);
  EXPECT_EQ(config.segments, segments::Offer::kUnix);
}

TEST(CommandLine, AcceptsEveryFlag) {
  const auto line = parse({"--listen",
                           "127.0.0.1:0",
                           "--port-file",
                           "p",
                           "--data-dir",
                           "d",
                           "--threads",
                           "3",
                           "--policy",
                           "full",
                           "--memory-budget",
                           "1000000",
                           "--max-rays-queued",
                           "5",
                           "--max-bytes-queued",
                           "6",
                           "--max-prefetches",
                           "0",
                           "--segments",
                           "local",
                           "--log-level",
                           "warn",
                           "--insecure",
                           "--admin",
                           "localhost:0",
                           "--drain-ms",
                           "7",
                           "--not-ready-ms",
                           "8",
                           "--slow-query-ms",
                           "9",
                           "--max-connection-age-s",
                           "10",
                           "--metrics-per-scene",
                           "--check-config"});
  ASSERT_TRUE(std::holds_alternative<CommandLine>(line));
  const ServerConfig& config = std::get<CommandLine>(line).config;
  EXPECT_EQ(config.listen, "127.0.0.1:0");
  EXPECT_EQ(config.port_file, "p");
  EXPECT_EQ(config.data_dir, "d");
  EXPECT_EQ(config.threads, 3);
  EXPECT_EQ(config.policy, scenegraph::Growth::kFull);
  EXPECT_EQ(config.memory_budget, 1'000'000u);
  EXPECT_EQ(config.admission.rays, 5u);
  EXPECT_EQ(config.admission.bytes, 6u);
  EXPECT_EQ(config.max_prefetches, 0);
  EXPECT_EQ(config.segments, segments::Offer::kLocal);
  EXPECT_EQ(std::get<CommandLine>(line).log_level, spdlog::level::warn);
  EXPECT_TRUE(config.insecure);
  EXPECT_EQ(config.admin, "localhost:0");
  EXPECT_EQ(config.drain, std::chrono::milliseconds(7));
  EXPECT_EQ(config.not_ready, std::chrono::milliseconds(8));
  EXPECT_EQ(config.slow_query, std::chrono::milliseconds(9));
  EXPECT_EQ(config.max_connection_age, std::chrono::seconds(10));
  EXPECT_TRUE(config.metrics_per_scene);
  EXPECT_TRUE(std::get<CommandLine>(line).check_only);
}

TEST(CommandLine, AFlagGoesBeforeTheEnvironmentAndThatBeforeTheFile) {
  const TemporaryFile file(
      "threads = 3\nmax-prefetches = 3\ndata-dir = \"d 3\"\ninsecure = true\ndrain-ms = 3\n"
      "policy = \"full\"\nmetrics-per-scene = true\n");
  const Variable threads("SIGHTLINED_THREADS", "2"), prefetches("SIGHTLINED_MAX_PREFETCHES", "2");
  const Variable insecure("SIGHTLINED_INSECURE", "false"), empty("SIGHTLINED_DRAIN_MS", "");
  const auto line = parse({"--threads", "1", "--config", file.path().c_str()});
  ASSERT_TRUE(std::holds_alternative<CommandLine>(line));
  const ServerConfig& config = std::get<CommandLine>(line).config;
  EXPECT_EQ(config.threads, 1);
  EXPECT_EQ(config.max_prefetches, 2);
  EXPECT_EQ(config.data_dir, "d 3");
  EXPECT_FALSE(config.insecure);
  EXPECT_EQ(config.drain, std::chrono::milliseconds(3));
  EXPECT_EQ(config.policy, scenegraph::Growth::kFull);
  EXPECT_TRUE(config.metrics_per_scene);
}

TEST(CommandLine, EverySettingOfBytesTakesUnits) {
  const TemporaryFile file(
      "max-bytes-queued = \"64MiB\"\n[quota]\nbytes-per-second = \"200MB\"\nbytes-stored = "
      "\"10G\"\n");
  const Variable budget("SIGHTLINED_MEMORY_BUDGET", "4g");
  const auto line = parse({"--config", file.path().c_str()});
  ASSERT_TRUE(std::holds_alternative<CommandLine>(line));
  const ServerConfig& config = std::get<CommandLine>(line).config;
  EXPECT_EQ(config.memory_budget, std::uint64_t{4} << 30);
  EXPECT_EQ(config.admission.bytes, std::uint64_t{64} << 20);
  EXPECT_EQ(config.quotas.others, (exec::QuotaLimits{0, 200'000'000, 0, std::uint64_t{10} << 30}));
  const auto flag = parse({"--memory-budget", "512MiB"});
  EXPECT_EQ(std::get<CommandLine>(flag).config.memory_budget, std::uint64_t{512} << 20);

  testing::internal::CaptureStdout();
  EXPECT_EQ(std::get<int>(parse({"--config", file.path().c_str(), "--print-config"})), 0);
  const std::string text = testing::internal::GetCapturedStdout();
  for (const std::string part :
       {"memory-budget = \"4g\"  # environment", "max-bytes-queued = \"64MiB\"  # file",
        "bytes-per-second = \"200MB\"  # file", "bytes-stored = \"10G\"  # file"})
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
}

TEST(CommandLine, AWrongSizeIsNamedWithItsLimits) {
  for (const char* const wrong : {"4Q", "1.5G", "99999999999G", "0k"}) {
    const std::string error = usage_error({"--memory-budget", wrong});
    EXPECT_NE(error.find("\"" + std::string(wrong) + "\" is not a size from 1 to "),
              std::string::npos)
        << error;
  }
  const TemporaryFile file("[quota]\nbytes-stored = \"10X\"\n");
  const std::string error = usage_error({"--config", file.path().c_str()});
  EXPECT_NE(error.find(file.path() + ":2: \"10X\" is not a size from 0 to "), std::string::npos)
      << error;
}

TEST(CommandLine, TheEnvironmentMayNameTheFile) {
  const TemporaryFile file("threads = 3\n[quota]\nrays-per-second = 5\n");
  const Variable named("SIGHTLINED_CONFIG", file.path().c_str());
  const auto line = parse({});
  ASSERT_TRUE(std::holds_alternative<CommandLine>(line));
  EXPECT_EQ(std::get<CommandLine>(line).config.threads, 3);
  EXPECT_EQ(std::get<CommandLine>(line).config.quotas.others[0], 5u);
}

TEST(CommandLine, NamesTheSourceOfAMistake) {
  for (const std::string bad : {"thread = 3", "threads = 0", "threads = \"x\"", "listen = \"host\"",
                                "insecure = 7", "config = \"a\"", "print-config = true",
                                "help = true", "[server]\nthreads = 3", "[quota]\nrays = 3"}) {
    const TemporaryFile file("\n" + bad + "\n");
    const std::string error = usage_error({"--config", file.path().c_str()});
    EXPECT_NE(error.find(file.path() + ":"), std::string::npos) << bad << ": " << error;
  }
  {
    const Variable threads("SIGHTLINED_THREADS", "0");
    EXPECT_NE(usage_error({}).find("SIGHTLINED_THREADS"), std::string::npos);
  }
  EXPECT_NE(usage_error({"--config", "/nowhere/x.toml"}).find("/nowhere/x.toml"),
            std::string::npos);
}

TEST(CommandLine, NotesVariablesThatAreNoSettings) {
  // As Kubernetes sets them for a service of this name.
  const Variable other("SIGHTLINED_SERVICE_HOST", "10.0.0.1");
  const auto line = parse({});
  ASSERT_TRUE(std::holds_alternative<CommandLine>(line));
  ASSERT_EQ(std::get<CommandLine>(line).notes.size(), 1u);
  EXPECT_NE(std::get<CommandLine>(line).notes[0].find("SIGHTLINED_SERVICE_HOST"),
            std::string::npos);
}

TEST(CommandLine, PrintsWhereEachValueComesFrom) {
  const TemporaryFile file("data-dir = \"d\"\n[quota]\nrays-per-second = 5\n");
  const Variable threads("SIGHTLINED_THREADS", "2");
  testing::internal::CaptureStdout();
  const auto line = parse({"--config", file.path().c_str(), "--policy", "full", "--print-config"});
  const std::string text = testing::internal::GetCapturedStdout();
  ASSERT_TRUE(std::holds_alternative<int>(line));
  EXPECT_EQ(std::get<int>(line), 0);
  for (const std::string& part :
       {std::string("listen = \"127.0.0.1:50151\"  # default\n"),
        std::string("threads = 2  # environment SIGHTLINED_THREADS\n"),
        std::string("policy = \"full\"  # flag\n"), std::string("# port-file is not set\n"),
        "data-dir = \"d\"  # file " + file.path() + ":1\n",
        std::string("insecure = false  # default\n"),
        "[quota]\nrays-per-second = 5  # file " + file.path() + ":3\n"})
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;

  // What is printed can be read again, and means the same.
  const TemporaryFile printed(text);
  const auto again = parse({"--config", printed.path().c_str()});
  ASSERT_TRUE(std::holds_alternative<CommandLine>(again));
  EXPECT_EQ(std::get<CommandLine>(again).config.data_dir, "d");
  EXPECT_EQ(std::get<CommandLine>(again).config.policy, scenegraph::Growth::kFull);
  EXPECT_EQ(std::get<CommandLine>(again).config.quotas.others[0], 5u);
}

TEST(CommandLine, PrintsEveryStringSoThatItIsReadAgain) {
  for (const std::string path : {"a", "a\"b", "a\\b", "a'b", "a'\"\\b#"}) {
    testing::internal::CaptureStdout();
    EXPECT_EQ(std::get<int>(parse({"--data-dir", path.c_str(), "--print-config"})), 0);
    const TemporaryFile printed(testing::internal::GetCapturedStdout());
    const auto again = parse({"--config", printed.path().c_str()});
    ASSERT_TRUE(std::holds_alternative<CommandLine>(again)) << path;
    EXPECT_EQ(std::get<CommandLine>(again).config.data_dir, path);
  }
}

TEST(CommandLine, PrintsNoPassword) {
  const Variable store("SIGHTLINED_STORE",
                       "postgresql://user:hidden@one,two:5433/db?sslmode=require");
  testing::internal::CaptureStdout();
  const auto line = parse({"--print-config"});
  const std::string text = testing::internal::GetCapturedStdout();
  EXPECT_NE(text.find("store = \"postgresql://user@one,two:5433/db?sslmode=require\""
                      "  # environment SIGHTLINED_STORE\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("hidden"), std::string::npos);
  const auto config = std::get<CommandLine>(parse({})).config;
  EXPECT_EQ(config.store, "postgresql://user:hidden@one,two:5433/db?sslmode=require");
  EXPECT_TRUE(config.is_durable());
}

TEST(CommandLine, AcceptsTheFlagsOfSecurity) {
  const auto line = parse({"--listen", "unix:/run/s", "--tls-cert", "c", "--tls-key", "k",
                           "--tls-client-ca", "a", "--tokens", "t"});
  ASSERT_TRUE(std::holds_alternative<CommandLine>(line));
  const ServerConfig& config = std::get<CommandLine>(line).config;
  EXPECT_EQ(config.listen, "unix:/run/s");
  EXPECT_EQ(config.tls.certificate, "c");
  EXPECT_EQ(config.tls.key, "k");
  EXPECT_EQ(config.tls.client_ca, "a");
  EXPECT_EQ(config.tokens, "t");
}

TEST(CommandLine, AnyMistakeIsAUsageError) {
  const std::vector<std::vector<const char*>> mistakes{{"--policy", "never"},
                                                       {"--policy", "2"},
                                                       {"--threads", "0"},
                                                       {"--threads", "x"},
                                                       {"--listen", "host"},
                                                       {"--listen", "h:9999999"},
                                                       {"--memory-budget", "0"},
                                                       {"--memory-budget", "-1"},
                                                       {"--nonsense"},
                                                       {"positional"},
                                                       {"--log-level", "loud"},
                                                       {"--policy"},
                                                       {"--listen", "unix:"},
                                                       {"--tokens"},
                                                       {"--max-prefetches", "65"},
                                                       {"--segments", "remote"}};
  for (const auto& flags : mistakes) {
    const auto line = parse(flags);
    ASSERT_TRUE(std::holds_alternative<int>(line)) << flags[0];
    EXPECT_EQ(std::get<int>(line), kUsageExit) << flags[0];
  }
}

TEST(CommandLine, HelpAndVersionExitWithZero) {
  EXPECT_EQ(std::get<int>(parse({"--help"})), 0);
  EXPECT_EQ(std::get<int>(parse({"--version"})), 0);
}

}  // namespace
}  // namespace sightline::server
