// Puts the sections together, under a table and above the circumstances.
#include "client/load/report/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "client/load/report/section.h"
#include "client/load/report/style.h"
#include "client/load/report/text.h"

namespace sightline::client::load::report {
namespace {

class Html {
 public:
  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }
  std::string finish() { return std::move(text_); }

 private:
  std::string text_;
};

std::string short_name(const std::string& scene) { return scene.substr(scene.rfind('/') + 1); }

std::string load_words(const LoadOptions& options, const LoadContext& context) {
  const std::string who = options.rate
                              ? fmt::format("{} requests a second", short_number(*options.rate))
                              : fmt::format("{} clients", options.clients);
  std::string words = fmt::format("{}, {} rays a request, rays: {}, question: {}", who,
                                  options.batch, context.rays, name_of(options.kind));
  if (options.updates > 0) words += fmt::format(", {} updates", percent(options.updates));
  return words;
}

void add_table(const LoadOptions& options, const LoadResult& result, Html& html) {
  html.add(
      "<div class=\"wide\" tabindex=\"0\"><table><thead><tr><th>run</th><th>rays/s</th><th>half "
      "within</th><th>99 % within</th>"
      "<th>slowest</th><th>first hit</th><th>all rays</th><th>built</th><th>failed</th>"
      "<th>refused</th></tr></thead><tbody>\n");
  for (const Row& row : result.rows) {
    const Record& record = row.run.record;
    const auto latency = [&](double share) {
      return duration(static_cast<double>(record.latency.quantile(share)) * 1e-9);
    };
    const std::string first =
        record.first_hit ? duration(seconds_of(*record.first_hit - record.begin)) : "-";
    const std::string built = row.growth.empty() || result.triangles_total == 0
                                  ? "-"
                                  : percent(static_cast<double>(row.growth.back().triangles_built) /
                                            static_cast<double>(result.triangles_total));
    const std::string all = row.cold && row.run.complete ? duration(duration_s(row)) : "-";
    html.add(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
        "<td>{}</td><td>{}</td><td>{}</td></tr>\n",
        label_of(row, options), short_number(rays_per_s(row)), latency(0.5), latency(0.99),
        duration(static_cast<double>(record.latency.max()) * 1e-9), first, all, built,
        record.failed, record.refused);
  }
  html.add("</tbody></table></div>\n");
}

void add_foot(const LoadContext& context, const LoadResult& result, Html& html) {
  const Machine& machine = context.machine;
  const ServerInfo& server = result.server;
  html.add("<footer><h2>How this was measured</h2><dl>\n");
  const auto item = [&](const char* name, const std::string& value) {
    html.add("<dt>{}</dt><dd>{}</dd>\n", name, escape(value));
  };
  item("Scene",
       fmt::format("{}, revision {}, {} triangles", result.scene.name, result.scene.revision,
                   short_number(static_cast<double>(result.triangles_total))));
  item("Server", fmt::format("sightlined {}, {} threads, {}, policy {}", server.version,
                             server.threads, server.simd_target, server.policy));
  item("Load test", fmt::format("sightline {}", context.client_version));
  item("Its machine",
       fmt::format("{} x {}, {} of memory, {}", machine.processors, machine.processor,
                   bytes(static_cast<double>(machine.memory_bytes)), machine.system));
  double share = 0;
  for (const Row& row : result.rows) share = std::max(share, row.use.own_share());
  item("Its own share", fmt::format("at most {} of that machine's processors", percent(share)));
  item("Time", machine.time);
  html.add("<dt>Command</dt><dd><code>{}</code></dd>\n</dl>\n", escape(context.command));
  html.add(
      "<p class=\"lead\">Latency is from when a request was due to its answer. A cold run begins "
      "without trees; of several, the one of median duration is shown. Coverage is the share of "
      "the "
      "points that rays go to, nearest to one of them.</p></footer>\n");
}

}  // namespace

std::string make_page(const LoadOptions& options, const LoadContext& context,
                      const LoadResult& result) {
  Html html;
  const std::string title = escape("Load test of " + short_name(result.scene.name));
  html.add(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n<h1>{}</h1>\n"
      "<p class=\"lead\">{}</p>\n",
      title, kStyle, title, escape(load_words(options, context)));
  for (const std::string& warning : result.warnings)
    html.add("<p class=\"note\">{}</p>\n", escape(warning));
  add_table(options, result, html);
  const Findings findings{options, result, find_crossovers(result.rows)};
  for (const auto& make : {over_coverage, over_rays, latency_by_percentile, latency_over_time,
                           throughput, triangles_over_time, bytes_over_time, where_time_went}) {
    const auto section = make(findings);
    if (!section) continue;
    html.add("<section><h2>{}</h2>\n<p>{}</p>\n", escape(section->title),
             escape(section->sentence));
    for (const std::string& figure : section->figures)
      html.add("<figure tabindex=\"0\">{}</figure>\n", figure);
    html.add("</section>\n");
  }
  html.add("</main>\n");
  add_foot(context, result, html);
  html.add("</body>\n</html>\n");
  return html.finish();
}

}  // namespace sightline::client::load::report
