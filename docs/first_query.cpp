// A first query: how high is the engine along its length? Build it with the tests, run it beside a
// server, whose endpoint may be its argument.
#include <cstdint>
#include <cstdio>
#include <vector>

#include "client/client.h"

using namespace sightline::client;

int main(int argc, char** argv) {
  const auto client = Client::connect(argc > 1 ? argv[1] : "127.0.0.1:50151");
  if (!client) return std::puts(client.error().message.c_str()), 1;

  std::vector<double> origins, directions;  // (n, 3): straight down, a ray every 10 units
  for (int x = -370; x <= 370; x += 10) {
    origins.insert(origins.end(), {static_cast<double>(x), 500, 0});
    directions.insert(directions.end(), {0, -1, 0});
  }
  const RayColumns<const double> rays{.origins = origins, .directions = directions};
  std::vector<double> t(rays.size());
  std::vector<std::uint64_t> node(rays.size());

  const auto report =
      client->cast_stream("projects/default/scenes/engine", rays, {.t = t, .node = node});
  if (!report) return std::puts(report.error().message.c_str()), 1;

  for (std::size_t i = 0; i < t.size(); ++i) {
    if (node[i] != 0)
      std::printf("x %4.0f  height %6.1f  node %d\n", origins[3 * i], 500 - t[i],
                  static_cast<int>(node[i]));
  }
  std::printf("%d of %d rays hit, at revision %d\n", static_cast<int>(report->hits),
              static_cast<int>(report->rays), static_cast<int>(report->revision));
}
