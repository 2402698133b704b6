// chart: the study of speed against accuracy.
#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/bench/charts/builders.h"
#include "tests/bench/charts/csv.h"
#include "tests/bench/charts/images.h"
#include "tests/bench/charts/plots.h"
#include "tests/bench/verbs/provenance.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCsv = "speed_accuracy.csv";

Error refused(std::string message) {
  return {Code::kInvalidArgument, std::move(message), "COMMAND_LINE"};
}

Status check(const CommonOptions& common, const ChartOptions& options) {
  if (options.out.empty()) return refused("--out is required");
  if (!common.scene.empty()) return refused("chart takes --scenes FILE ..., not --scene");
  if (!common.set.empty()) return refused("chart takes no --set: its builders are a fixed table");
  if (!common.policy.empty()) return refused("chart takes no --policy: it compares them");
  return {};
}

Error no_file(const fs::path& path, const std::string& why) {
  return {Code::kFailedPrecondition, fmt::format("{}: {}", path.string(), why), "OUT"};
}

// Written to a temporary file and then renamed, so that a reader never sees half of a study.
Status write_whole(const fs::path& path, const std::string& text) {
  fs::path aside = path;
  aside += ".new";
  std::ofstream file(aside);
  file << text << std::flush;
  if (!file) return no_file(aside, "cannot be written");
  std::error_code error;
  fs::rename(aside, path, error);
  return error ? Status(no_file(path, error.message())) : Status();
}

// Checks the output folder before minutes of work.
Status check_writable(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return no_file(folder, error.message());
  const fs::path probe = folder / ".probe";
  const bool opened = std::ofstream(probe).is_open();
  fs::remove(probe, error);
  return opened ? Status() : Status(no_file(folder, "nothing can be written there"));
}

class Study {
 public:
  Study(CommonOptions common, const ChartPlan& plan) : common_(std::move(common)), plan_(plan) {}

  Result<std::vector<Row>> measure(const std::vector<ChartScene>& scenes) {
    const std::vector<ChartContender> contenders = chart_contenders();
    for (const ChartScene& scene : scenes) {
      print_progress(fmt::format("{}: {} builders", scene.name, contenders.size()));
      if (auto done = add(chart_builders(scene, contenders, common_, plan_)); !done.ok()) {
        return named(done.error(), scene.name);
      }
      print_progress(fmt::format("{}: time to image", scene.name));
      if (auto done = add(chart_images(scene, common_, plan_)); !done.ok()) {
        return named(done.error(), scene.name);
      }
    }
    add_provenance();
    return std::move(rows_);
  }

 private:
  Status add(Result<std::vector<Row>> rows) {
    if (!rows.ok()) return rows.error();
    rows_.insert(rows_.end(), std::move_iterator(rows->begin()), std::move_iterator(rows->end()));
    return {};
  }

  void add_provenance() {
    const Provenance from = provenance();
    for (Row& row : rows_) {
      row["threads"] = common_.threads;
      row["repeat"] = common_.repeat;
      row["seed"] = common_.seed;
      if (!common_.rotate.empty()) row["rotate"] = common_.rotate;
      row["machine"] = from.machine;
      row["compiler"] = from.compiler;
      row["commit"] = from.commit;
      row["date"] = from.date;
    }
  }

  void print_progress(const std::string& what) const {
    fmt::print(stderr, "sightline-bench: {:4.0f} s  {}\n", clock_.seconds(), what);
  }

  static Error named(const Error& error, const std::string& scene) {
    return {error.code, scene + ": " + error.message, error.reason};
  }

  CommonOptions common_;
  ChartPlan plan_;
  Stopwatch clock_;
  std::vector<Row> rows_;
};

Row file_row(const fs::path& file) {
  Row row;
  row["file"] = file.string();
  row["bytes"] = fs::file_size(file);
  return row;
}

}  // namespace

Result<std::vector<Row>> run_chart(const CommonOptions& common, const ChartOptions& options) {
  if (auto good = check(common, options); !good.ok()) return good.error();
  const auto scenes = load_chart_scenes(options.scenes, common);
  if (!scenes.ok()) return scenes.error();
  const fs::path csv = fs::path(options.out) / kCsv;
  if (auto good = check_writable(options.out); !good.ok()) return good.error();
  auto measured = Study(common, options.quick ? kQuickChart : ChartPlan{}).measure(*scenes);
  if (!measured.ok()) return measured.error();
  const auto text = chart_csv(*measured);
  if (!text.ok()) return text.error();
  if (auto written = write_whole(csv, *text); !written.ok()) return written.error();
  std::vector<Row> rows{file_row(csv)};
  const auto plots = draw_chart_plots(csv);
  if (!plots.ok()) return plots.error();
  for (const fs::path& plot : *plots) rows.push_back(file_row(plot));
  return rows;
}

}  // namespace sightline::bench
