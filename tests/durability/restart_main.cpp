// How long a server takes to start with much in its data directory, and whether its first answers
// are right.
//
//   sightline-restart [--scenes N] [--triangles M] [--dir DIR] [--server PROGRAM]
#include <signal.h>
#include <stdlib.h>

#include <fmt/format.h>
#include <grpcpp/client_context.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/server/support/api.h"
#include "tests/server/support/live_server.h"
#include "tests/support/brute_force.h"
#include "tests/support/child_process.h"
#include "tests/support/compare_hits.h"
#include "tests/support/random.h"

namespace sightline::tests::durability {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  std::size_t scenes = 1000;
  std::size_t triangles = 10'000'000;  // in all scenes
  std::string directory;
  std::string server = SIGHTLINED;
};

double ms_since(Clock::time_point begun) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begun).count();
}

std::string scene_name(std::size_t number) { return fmt::format("projects/p/scenes/s{}", number); }

class Run {
 public:
  explicit Run(const Options& options) : options_(options) {}

  int run() {
    const Clock::time_point begun = Clock::now();
    if (!live([this](Api& api) { fill(api); }, SIGTERM)) return 1;
    fmt::print("scenes {}\ntriangles {}\nfilled in s {:.1f}\n", options_.scenes,
               options_.scenes * triangles_of_one(), ms_since(begun) / 1000);
    const auto check = [this](Api& api) {
      cast(api, 0);
      cast(api, options_.scenes / 2);
      list(api);
    };
    return live(check, SIGKILL) && live(check, SIGTERM) && right_ ? 0 : 1;
  }

 private:
  std::size_t triangles_of_one() const { return options_.triangles / options_.scenes; }
  TestMesh mesh_of(std::size_t scene) const {
    return random_soup(static_cast<std::uint32_t>(triangles_of_one()), 0.05, scene + 1);
  }

  template <class Use>
  bool live(const Use& use, int end) {
    const Clock::time_point begun = Clock::now();
    ChildProcess server(options_.server,
                        {"--listen", "127.0.0.1:0", "--data-dir", options_.directory, "--threads",
                         "2", "--memory-budget", "4000000000"});
    const int port = std::atoi(server.rest_of_line(" port=").c_str());
    if (port == 0) {
      fmt::print("the server does not start: {}\n", server.output());
      return false;
    }
    fmt::print("ready after ms {:.0f}\n", ms_since(begun));
    {
      Api api(connect(port));
      use(api);
    }
    fmt::print("resident MB {}\n", server.resident_bytes() >> 20);
    server.signal(end);
    server.wait();
    return true;
  }

  void fill(Api& api) {
    for (std::size_t i = 0; i < options_.scenes; ++i) api.make_scene(scene_name(i), mesh_of(i));
  }

  void cast(Api& api, std::size_t number) {
    const TestMesh mesh = mesh_of(number);
    const auto rays = rays_at(mesh, 200, number);
    v1::CastRaysRequest request = cast_request(scene_name(number), rays);
    for (const v1::HitField field :
         {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE, v1::HIT_FIELD_BARYCENTRIC,
          v1::HIT_FIELD_NORMAL, v1::HIT_FIELD_HIT})
      request.add_fields(field);
    v1::CastRaysResponse reply;
    const Clock::time_point begun = Clock::now();
    const grpc::Status status = api.cast(request, &reply);
    fmt::print("first cast ms {:.0f}\n", ms_since(begun));
    const std::vector<PlacedMesh> placed{{.mesh = mesh.view()}};
    const bool same = status.ok() && compare(rays, decode_hits(reply), BruteForce(placed)).clean();
    if (same) return;
    fmt::print("wrong answers: {}\n", status.error_message());
    right_ = false;
  }

  void list(Api& api) {
    const Clock::time_point begun = Clock::now();
    v1::ListScenesRequest request;
    request.set_parent("projects/p");
    request.set_page_size(1000);
    v1::ListScenesResponse reply;
    grpc::ClientContext context;
    const grpc::Status listed = api.scenes->ListScenes(&context, request, &reply);
    fmt::print("list of {} scenes ms {:.0f}\n", reply.scenes_size(), ms_since(begun));
    if (listed.ok()) return;
    fmt::print("no list: {}\n", listed.error_message());
    right_ = false;
  }

  const Options options_;
  bool right_ = true;
};

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Measures the start of a server with much in its data directory");
  app.add_option("--scenes", options.scenes)->check(CLI::PositiveNumber);
  app.add_option("--triangles", options.triangles, "In all scenes")->check(CLI::PositiveNumber);
  app.add_option("--dir", options.directory, "An empty directory; default: a temporary one");
  app.add_option("--server", options.server);
  CLI11_PARSE(app, argc, argv);
  const bool temporary = options.directory.empty();
  if (temporary) {
    std::string pattern = std::filesystem::temp_directory_path() / "sightline-restart-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) return 1;
    options.directory = pattern;
  }
  const int code = Run(options).run();
  if (temporary) std::filesystem::remove_all(options.directory);
  return code;
}

}  // namespace
}  // namespace sightline::tests::durability

int main(int argc, char** argv) { return sightline::tests::durability::run(argc, argv); }
