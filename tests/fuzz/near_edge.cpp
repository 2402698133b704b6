// near_edge [--pairs N] [--seed S] [--flush]: checks the intersector against exact arithmetic on
// rays that pass near edges and vertices. Exits with 1 on any error.
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "tests/fuzz/near_edges.h"

namespace {

using sightline::tests::PairCount;

struct Options {
  std::uint64_t pairs = 1000000;
  std::uint64_t seed = 1;
  bool flush = false;
};

bool parse_number(std::string_view text, std::uint64_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

bool parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == "--flush") {
      options.flush = true;
    } else if ((word == "--pairs" || word == "--seed") && i + 1 < argc) {
      if (!parse_number(argv[++i], word == "--pairs" ? options.pairs : options.seed)) return false;
    } else {
      return false;
    }
  }
  return true;
}

unsigned long long wide(std::uint64_t x) { return x; }

void print_row(const char* name, const PairCount& c) {
  std::printf(
      "%-12s %11llu %11llu %11llu %11llu %10llu %10llu %8llu %8llu %8llu %8llu %8llu %8llu\n", name,
      wide(c.pairs), wide(c.near), wide(c.hits), wide(c.zeros), wide(c.one), wide(c.folded),
      wide(c.wrong_hits), wide(c.wrong_misses), wide(c.wrong_t), wide(c.wrong_weights),
      wide(c.wrong_facing), wide(c.wrong_sums));
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) {
    std::fprintf(stderr,
                 "usage: near_edge [--pairs N] [--seed S] [--flush]\n"
                 "  --pairs N  pairs of a ray and a triangle with the ray within 1e-6 of an edge\n"
                 "  --flush    with denormal results flushed to zero\n");
    return 2;
  }
  const auto start = std::chrono::steady_clock::now();
  const auto tally = sightline::tests::check_near_edges(
      options.pairs, options.seed, {.all_orders = false, .flush_denormals = options.flush});
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

  // "zeros": a determinant is exactly zero. "one", "0 or 2": patches whose sum of hits is known.
  std::printf("%-12s %11s %11s %11s %11s %10s %10s %8s %8s %8s %8s %8s %8s\n", "patch", "pairs",
              "near", "hits", "zeros", "one", "0 or 2", "wrong", "misses", "wrong t", "weights",
              "facing", "sums");
  constexpr const char* kNames[] = {"triangle", "pair", "fan", "tetrahedron"};
  for (std::size_t i = 0; i < sightline::tests::kPatches; ++i) {
    print_row(kNames[i], tally.by_patch[i]);
  }
  const PairCount total = tally.total();
  print_row("total", total);
  std::printf("largest errors, in units of the largest |v - o|: t 2^%.2f, weighted point 2^%.2f\n",
              std::log2(tally.largest_t_error), std::log2(tally.largest_point_error));
  std::printf("mismatches: %llu, %.1f s\n", wide(total.wrong()), seconds.count());
  for (const std::string& finding : tally.findings) std::printf("%s\n", finding.c_str());
  return total.wrong() == 0 ? 0 : 1;
}
