// sightline load: how fast a server answers rays, measured and reported.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "client/cli/files/ray_file.h"
#include "client/cli/flags.h"
#include "client/cli/reporting.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/load_output.h"
#include "client/cli/verbs/verbs.h"
#include "client/load/check.h"
#include "client/load/load_test.h"

namespace sightline::client::cli::verbs {
namespace {

struct LoadArguments {
  load::LoadOptions options;
  std::string rays = "overview";
  std::string kind = "closest";
  std::vector<std::string> compare;
  std::string check;
  LoadOutput output{.page = {}, .before = {}, .tolerance = load::kDefaultTolerance};
};

/// All rays of a file.
Result<load::RaySet> read_rays(const std::string& file, const std::stop_token& stop) {
  auto opened = files::open_rays(file, stop);
  if (!opened) return opened.error();
  files::wait_out_pauses(*opened);
  return std::visit(
      [&]<class Scalar>(const RaySource<Scalar>& source) -> Result<load::RaySet> {
        const bool with_interval = opened->shape.interval;
        std::vector<Scalar> origins(3 * kRaysPerMessage), directions(3 * kRaysPerMessage);
        std::vector<Scalar> tmin(with_interval ? kRaysPerMessage : 0), tmax(tmin.size());
        load::RaySet rays = load::RaySet::copy<Scalar>({});
        for (;;) {
          const auto count = source({origins, directions, tmin, tmax, {}});
          if (!count) return count.error();
          if (*count == 0) return rays;
          const auto part = [&](const std::vector<Scalar>& all, std::size_t width) {
            return std::span(all).first(std::min(all.size(), *count * width));
          };
          rays.append<Scalar>(
              {part(origins, 3), part(directions, 3), part(tmin, 1), part(tmax, 1), {}});
        }
      },
      opened->source);
}

Status choose_rays(LoadArguments& arguments, const std::stop_token& stop) {
  const auto kind = load::kRayKinds.find(arguments.rays);
  if (kind != load::kRayKinds.end()) {
    arguments.options.rays = kind->second;
    return {};
  }
  auto rays = read_rays(arguments.rays, stop);
  if (!rays) return rays.error();
  if (rays->size() == 0) return local_error(arguments.rays + ": there are no rays");
  arguments.options.rays = *std::move(rays);
  return {};
}

Result<Json> read_result(const std::string& file) {
  std::ifstream in(file);
  const std::string text(std::istreambuf_iterator<char>(in), {});
  if (!in) return local_error(fmt::format("cannot read {}", file));
  Json document = Json::parse(text, nullptr, false);
  if (document.is_discarded()) return local_error(fmt::format("{} is not JSON", file));
  return document;
}

Result<load::LoadResult> measure(const Session& session, const LoadArguments& arguments,
                                 const std::stop_token& stop) {
  const auto connect = [&] {
    Session own = session;
    own.options.own_connection = true;
    return own.connect();
  };
  ProgressBar bar("measuring");
  return load::run_load(arguments.options, connect, stop,
                        [&](const std::string& label, double fraction, std::uint64_t rays) {
                          bar.update(fraction,
                                     fmt::format("{}, {} rays", label, format_count(rays)));
                        });
}

ExitCode run(const Session& session, LoadArguments& arguments, const std::string& command) {
  const Interrupt interrupt;
  if (!arguments.check.empty()) {
    auto read = read_result(arguments.check);
    if (!read) return fail(read.error());
    arguments.output.before = *std::move(read);
  }
  if (const Status chosen = choose_rays(arguments, interrupt.token()); !chosen) {
    if (interrupt.happened()) return say_interrupted();
    return fail(chosen.error());
  }
  const load::LoadContext context{.rays = arguments.rays,
                                  .command = command,
                                  .client_version = SIGHTLINE_VERSION,
                                  .machine = load::this_machine()};
  auto result = measure(session, arguments, interrupt.token());
  for (int runs = 1; result && runs < load::kRunsToConfirm; ++runs) {
    if (!seems_slower(arguments.output, arguments.options, context, *result)) break;
    print_warning("slower than the earlier result: measured again, to be sure");
    result = measure(session, arguments, interrupt.token());
  }
  if (!result && interrupt.happened()) return say_interrupted();
  if (!result) return fail(result.error());
  return put_out(session, arguments.output, arguments.options, context, *result);
}

/// "1,10,100" as percent.
std::vector<double> parse_coverage(const std::vector<std::string>& words) {
  std::vector<double> all;
  for (const std::string& word : words) {
    const auto number = parse_number(word);
    if (!number || !(*number > 0) || *number > 100)
      throw CLI::ValidationError("--coverage", "'" + word + "' is not a percentage above 0");
    all.push_back(*number);
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

void add_load_flags(CLI::App& verb, LoadArguments& arguments) {
  load::LoadOptions& options = arguments.options;
  verb.add_option("--rays", arguments.rays,
                  "Rays to cast: a file as cast takes it, or overview, closeup, diffuse, shadow, "
                  "random (default overview)")
      ->type_name("FILE|KIND");
  verb.add_option("--kind", arguments.kind, "What is asked about each ray (default closest)")
      ->check(CLI::IsMember(kQueryKinds).description(""))
      ->type_name("closest|any|all|count");
  CLI::Option* const clients =
      verb.add_option(
              "--clients", options.clients,
              "Closed loop: connections that send their next request when the one before is "
              "answered (default 4)")
          ->check(CLI::Range(1, 1024).description(""))
          ->type_name("N");
  verb.add_option("--rate", options.rate,
                  "Open loop: requests a second, each timed from when it was due")
      ->check(positive_number())
      ->excludes(clients)
      ->type_name("R");
  verb.add_option("--batch", options.batch, "Rays a request (default 8192)")
      ->check(CLI::Range(1, 16384).description(""))
      ->type_name("N");
  verb.add_option(
          "--updates", options.updates,
          "This share of the requests moves a node, a copy of one, that is deleted at the end")
      ->check(CLI::Range(0.0, 1.0).description(""))
      ->type_name("SHARE");
  verb.add_option("--seconds", options.seconds,
                  "How long a run measures (default: until it is stable)")
      ->check(positive_number())
      ->type_name("S");
}

void add_comparing_flags(CLI::App& verb, LoadArguments& arguments) {
  load::LoadOptions& options = arguments.options;
  CLI::Option* const compare =
      verb.add_option("--compare", arguments.compare,
                      "Cold runs, each without trees at its beginning, of these in turn")
          ->delimiter(',')
          ->check(CLI::IsMember({"lazy", "full", "none"}).description(""))
          ->type_name("lazy,full,none");
  verb.add_option("--count", options.rays_per_run, "Rays of a cold run (default 1000000)")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40).description(""))
      ->needs(compare)
      ->type_name("N");
  verb.add_option("--repeat", options.repeat, "Cold runs of each (default 3); the median is shown")
      ->check(CLI::Range(1, 1000).description(""))
      ->needs(compare)
      ->type_name("N");
  verb.add_option("--seed", options.seed, "Of the random rays (default 1)")->type_name("N");
  verb.add_option("--report", arguments.output.page,
                  "Write a page with plots; it needs nothing else")
      ->type_name("FILE.html");
  CLI::Option* const check =
      verb.add_option("--check", arguments.check,
                      "Exit with 1 if this run is slower than an earlier one, whose --json this is")
          ->type_name("OLD.json");
  verb.add_option("--tolerance", arguments.output.tolerance,
                  "By which share it may be slower (default 0.1)")
      ->check(positive_number())
      ->needs(check)
      ->type_name("F");
}

constexpr const char* kLoadFooter =
    R"(A run without --compare is warm: trees grow as the server's policy says, before and while it measures.
--compare drops the scene's trees before each run, also for others who use the scene.

Examples:
  sightline load engine --clients 8 --seconds 10
  sightline load engine --rate 200 --batch 256 --kind any
  sightline load engine --compare lazy,full --coverage 1,10,100 --report engine.html
  sightline load engine --rays rays.npy --json > today.json
  sightline load engine --rays rays.npy --check today.json --tolerance 0.1)";

}  // namespace

void add_load_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("load", "Measure how fast a server answers");
  const auto arguments = std::make_shared<LoadArguments>();
  const auto coverage = std::make_shared<std::vector<std::string>>();
  add_scene_argument(verb, arguments->options.scene);
  add_load_flags(verb, *arguments);
  add_comparing_flags(verb, *arguments);
  verb.add_option("--coverage", *coverage,
                  "Percentages: only the rays to this share of the scene, a run for each")
      ->delimiter(',')
      ->type_name("1,10,100");
  verb.footer(kLoadFooter);
  verb.callback([&session, arguments, coverage] {
    arguments->options.kind = kQueryKinds.at(arguments->kind);
    if (!coverage->empty()) arguments->options.coverage = parse_coverage(*coverage);
    for (const std::string& build : arguments->compare)
      arguments->options.compare.push_back(load::kBuilds.at(build));
    session.exit = run(session, *arguments, session.command);
  });
}

}  // namespace sightline::client::cli::verbs
