// The flags of sightlined, and addresses to listen on.
#include "server/config.h"

#include <gtest/gtest.h>

#include <vector>

namespace sightline::server {
namespace {

std::variant<CommandLine, int> parse(std::vector<const char*> flags) {
  flags.insert(flags.begin(), "sightlined");
  return parse_command_line(static_cast<int>(flags.size()), flags.data());
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
}

TEST(CommandLine, AcceptsEveryFlag) {
  const auto line = parse({"--listen",          "127.0.0.1:0", "--port-file",        "p",
                           "--data-dir",        "d",           "--threads",          "3",
                           "--policy",          "full",        "--memory-budget",    "1000000",
                           "--max-rays-queued", "5",           "--max-bytes-queued", "6",
                           "--max-prefetches",  "0",           "--log-level",        "warn",
                           "--insecure"});
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
  EXPECT_EQ(std::get<CommandLine>(line).log_level, spdlog::level::warn);
  EXPECT_TRUE(config.insecure);
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
  const std::vector<std::vector<const char*>> mistakes{{"--policy", "demand"},
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
                                                       {"--tls-cert", "c"},
                                                       {"--tls-key", "k"},
                                                       {"--tls-client-ca", "a"},
                                                       {"--tokens"},
                                                       {"--max-prefetches", "65"}};
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
