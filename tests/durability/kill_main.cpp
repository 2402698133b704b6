// Kills a server at random instants while it is written to, and checks what it keeps.
//
//   sightline-kills [--kills N] [--seed S] [--dir DIR | --store URI] [--server PROGRAM] [--relaxed]
#include <signal.h>
#include <stdlib.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "tests/durability/other_writers.h"
#include "tests/durability/producer.h"
#include "tests/durability/witness.h"
#include "tests/server/support/live_server.h"
#include "tests/support/child_process.h"

namespace sightline::tests::durability {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

constexpr std::size_t kRays = 200;  // after each restart
constexpr int kProducers = 4;
/// The server lives for a random time up to this after its start.
constexpr double kLongestLife = 1500;  // ms

struct Options {
  int kills = 20;
  std::uint64_t seed = 1;
  std::string directory;
  std::string store;
  std::string server = SIGHTLINED;
  bool relaxed = false;
};

class Run {
 public:
  explicit Run(const Options& options) : options_(options), random_(options.seed) {
    for (const TestMesh& mesh : {cube(), icosphere(1), random_soup(50, 1, 7)}) {
      meshes_.push_back(mesh);
      digests_.push_back(witness_.add_mesh(mesh));
    }
    for (int i = 0; i < kProducers; ++i)
      producers_.push_back(std::make_unique<Producer>(
          i, Producer::Options{digests_, options.relaxed, witness_.seen()}, findings_));
  }

  int run() {
    for (int kill = 0; kill < options_.kills; ++kill) {
      if (!live_once(kill)) break;
      std::fprintf(stderr, "kill %d: revision %llu\n", kill + 1,
                   static_cast<unsigned long long>(witness_.revision()));
    }
    live_once(options_.kills);  // the state after the last kill
    return report();
  }

 private:
  bool live_once(int round) {
    const Clock::time_point begun = Clock::now();
    const bool is_shared = !options_.store.empty();
    ChildProcess server(options_.server,
                        {"--listen", "127.0.0.1:0", is_shared ? "--store" : "--data-dir",
                         is_shared ? options_.store : options_.directory, "--threads", "2"});
    const int port = std::atoi(server.rest_of_line(" port=").c_str());
    if (port == 0) {
      findings_.add(findings_.other, "the server does not start: " + server.output());
      return false;
    }
    restarts_.push_back(Milliseconds(Clock::now() - begun).count());
    {
      Api api(connect(port));
      if (round == 0) begin(api);
      check(api);
      if (round < options_.kills) write_until_killed(api, server);
    }
    server.signal(SIGKILL);
    server.wait();
    return true;
  }

  void begin(Api& api) {
    if (const grpc::Status made = api.create(kScene); !made.ok())
      findings_.add(findings_.other, made.error_message());
    for (const TestMesh& mesh : meshes_) api.add_mesh(mesh);
  }

  /// While no client writes.
  void check(Api& api) {
    const std::uint64_t head = api.get(kScene).head().revision();
    std::uint64_t reported = requester_.revision();
    if (options_.relaxed) {
      witness_.go_back(head);
    } else {
      reported = std::max(reported, witness_.revision());
      for (const auto& producer : producers_) reported = std::max(reported, producer->revision());
    }
    if (head < reported)
      findings_.add(findings_.lost,
                    fmt::format("revision {} was reported, the newest is {}", reported, head));
    if (head > 0) witness_.watch(api, head);
    if (witness_.revision() > 0) witness_.check_rays(api, kRays, random_.next());
    for (std::uint64_t i = 1; i <= requester_.acknowledged(); ++i) {
      if (!witness_.requests().contains(fmt::format("request-{}", i)))
        findings_.add(findings_.lost, fmt::format("request {} is gone", i));
    }
    uploader_.check(api);
  }

  void write_until_killed(Api& api, ChildProcess& server) {
    std::vector<std::jthread> threads;
    for (const auto& producer : producers_)
      threads.emplace_back([&api, &producer] { producer->run(api); });
    threads.emplace_back([&] { requester_.run(api); });
    threads.emplace_back([&] { uploader_.run(api); });
    threads.emplace_back([&] { witness_.watch(api); });
    std::this_thread::sleep_for(Milliseconds(random_.uniform(0, kLongestLife)));
    server.signal(SIGKILL);
    threads.clear();
    check_skipped();
  }

  void check_skipped() {
    for (const auto& producer : producers_) {
      const auto skipped = witness_.skipped().find(producer->name());
      if (skipped == witness_.skipped().end()) continue;
      for (const std::uint64_t sequence : skipped->second) {
        if (!producer->is_bad(sequence))
          findings_.add(findings_.gaps,
                        fmt::format("batch {} of {} was left out", sequence, producer->name()));
      }
    }
  }

  int report() {
    std::uint64_t batches = 0, forgotten = 0;
    for (const auto& producer : producers_) {
      batches += producer->acknowledged();
      forgotten += producer->forgotten();
    }
    std::ranges::sort(restarts_);
    fmt::print(
        "kills {}\nrevisions {}\nbatches acknowledged {}\nrelaxed batches forgotten {}\nrequests "
        "acknowledged {}\n"
        "uploads acknowledged {}\nrays compared {}\nrestart ms median {:.0f} max {:.0f}\n"
        "lost {}\nhalf applied {}\ngaps {}\napplied twice {}\nuploads missing {}\n"
        "wrong answers {}\nother failures {}\n",
        options_.kills, witness_.revision(), batches, forgotten, requester_.acknowledged(),
        uploader_.acknowledged(), witness_.rays(), restarts_[restarts_.size() / 2],
        restarts_.back(), findings_.lost, findings_.halves, findings_.gaps, findings_.repeats,
        findings_.missing, findings_.wrong, findings_.other);
    for (const std::string& example : findings_.examples()) fmt::print("  {}\n", example);
    return findings_.clean() ? 0 : 1;
  }

  const Options options_;
  Findings findings_;
  Random random_;
  std::vector<TestMesh> meshes_;
  std::vector<std::string> digests_;
  Witness witness_{findings_};
  std::vector<std::unique_ptr<Producer>> producers_;
  Requester requester_{findings_};
  Uploader uploader_{findings_};
  std::vector<double> restarts_;  // ms until the server is ready
};

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Kills a server at random instants and checks what it keeps");
  app.add_option("--kills", options.kills)->check(CLI::PositiveNumber);
  app.add_option("--seed", options.seed);
  auto* const directory =
      app.add_option("--dir", options.directory, "Data directory; default: a temporary one");
  app.add_option("--store", options.store, "An empty database of PostgreSQL, by its URI")
      ->excludes(directory);
  app.add_option("--server", options.server);
  app.add_flag("--relaxed", options.relaxed, "Streams of durability RELAXED");
  CLI11_PARSE(app, argc, argv);
  const bool temporary = options.directory.empty() && options.store.empty();
  if (temporary) {
    std::string pattern = (std::filesystem::temp_directory_path() / "sightline-kills-XXXXXX");
    if (mkdtemp(pattern.data()) == nullptr) return 1;
    options.directory = pattern;
  }
  const int code = Run(options).run();
  if (temporary && code == 0) std::filesystem::remove_all(options.directory);
  return code;
}

}  // namespace
}  // namespace sightline::tests::durability

int main(int argc, char** argv) { return sightline::tests::durability::run(argc, argv); }
