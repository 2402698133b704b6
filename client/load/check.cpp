// Finds the rows of one document in the other.
#include "client/load/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace sightline::client::load {
namespace {

using nlohmann::ordered_json;

constexpr const char* kFailed = "failed";
constexpr const char* kRefused = "refused";

Error unlike(std::string message) {
  return {Code::kInvalidArgument, std::move(message), "NOT_COMPARABLE"};
}

std::string row_name(const ordered_json& row) {
  return fmt::format("{} at {} %", row.at("build").get<std::string>(),
                     row.at("coverage").get<double>());
}

const ordered_json* same_row(const ordered_json& rows, const ordered_json& wanted) {
  for (const ordered_json& row : rows) {
    if (row.at("build") == wanted.at("build") && row.at("coverage") == wanted.at("coverage") &&
        row.at("cold") == wanted.at("cold"))
      return &row;
  }
  return nullptr;
}

class RowCheck {
 public:
  RowCheck(const ordered_json& before, const ordered_json& now, std::vector<Regression>& found)
      : before_(before), now_(now), found_(found) {}

  void must_not_fall(const char* figure, double tolerance) {
    const auto [before, now] = values(figure);
    if (now * (1 + tolerance) < before) add(figure, before, now);
  }
  void must_not_rise(const char* figure, double tolerance) {
    const auto [before, now] = values(figure);
    if (now > before * (1 + tolerance)) add(figure, before, now);
  }

 private:
  std::pair<double, double> values(const char* figure) const {
    return {before_.at(figure).get<double>(), now_.at(figure).get<double>()};
  }
  void add(const char* figure, double before, double now) {
    found_.push_back({row_name(now_), figure, before, now});
  }

  const ordered_json& before_;
  const ordered_json& now_;
  std::vector<Regression>& found_;
};

Result<std::vector<Regression>> compare(const ordered_json& before, const ordered_json& now,
                                        double tolerance) {
  for (const char* key : {"scene", "kind", "rays", "batch", "clients", "rate", "updates"}) {
    if (before.at(key) != now.at(key)) {
      return unlike(fmt::format("the old result has {} = {}, this one has {}", key,
                                before.at(key).dump(), now.at(key).dump()));
    }
  }
  std::vector<Regression> found;
  for (const ordered_json& row : now.at("rows")) {
    const ordered_json* const old = same_row(before.at("rows"), row);
    if (old == nullptr) return unlike("the old result has no row " + row_name(row));
    RowCheck check(*old, row, found);
    check.must_not_fall("rays_per_s", tolerance);
    if (!row.at("cold").get<bool>()) {
      check.must_not_rise("p50_ms", tolerance);
      check.must_not_rise("p99_ms", kTailFactor * tolerance);
    }
    check.must_not_rise(kFailed, 0);
    check.must_not_rise(kRefused, 0);
  }
  return found;
}

}  // namespace

Result<std::vector<Regression>> find_regressions(const ordered_json& before,
                                                 const ordered_json& now, double tolerance) {
  try {
    return compare(before, now, tolerance);
  } catch (const ordered_json::exception& e) {
    return unlike(fmt::format("the old result is not one of a load test: {}", e.what()));
  }
}

bool may_be_noise(const std::vector<Regression>& regressions) {
  return std::ranges::none_of(regressions, [](const Regression& regression) {
    return regression.figure == kFailed || regression.figure == kRefused;
  });
}

std::string to_string(const Regression& regression) {
  return fmt::format("{}: {} was {:.6g} and is {:.6g}", regression.row, regression.figure,
                     regression.before, regression.now);
}

}  // namespace sightline::client::load
