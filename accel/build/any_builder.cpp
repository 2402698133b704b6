// Builders by name, parameters by name.
#include "accel/build/any_builder.h"

#include <charconv>
#include <functional>
#include <map>

namespace sightline::accel {
namespace {

struct Named {
  std::string_view name;
  AnyBuilder builder;
};

const std::vector<Named>& all_builders() {
  static const std::vector<Named> kBuilders = {
      {"scan-one-axis", ScanBuilder{.axes = ScanAxes::kOne}},
      {"scan-hybrid", ScanBuilder{.axes = ScanAxes::kHybrid}},
      {"scan-all-axes", ScanBuilder{.axes = ScanAxes::kAll}},
  };
  return kBuilders;
}

Error invalid(std::string message) { return {Code::kInvalidArgument, std::move(message), "BUILDER_PARAMETER"}; }

using Setter = std::function<void(ScanBuilder&, double)>;

std::uint32_t to_count(double x) { return x >= 0 && x < 4294967295.0 ? static_cast<std::uint32_t>(x) : 4294967295u; }

const std::map<std::string_view, Setter>& scan_parameters() {
  static const std::map<std::string_view, Setter> kParameters = {
      {"samples", [](ScanBuilder& b, double x) { b.uniform_samples = b.adaptive_samples = to_count(x); }},
      {"uniform_samples", [](ScanBuilder& b, double x) { b.uniform_samples = to_count(x); }},
      {"adaptive_samples", [](ScanBuilder& b, double x) { b.adaptive_samples = to_count(x); }},
      {"exact_below", [](ScanBuilder& b, double x) { b.exact_below = to_count(x); }},
      {"hybrid_below", [](ScanBuilder& b, double x) { b.hybrid_below = to_count(x); }},
      {"cost_traverse", [](ScanBuilder& b, double x) { b.cost.traverse = x; }},
      {"cost_intersect", [](ScanBuilder& b, double x) { b.cost.intersect = x; }},
      {"empty_bonus", [](ScanBuilder& b, double x) { b.cost.empty_bonus = x; }},
  };
  return kParameters;
}

Status set(ScanBuilder& builder, std::string_view key, std::string_view value) {
  const auto found = scan_parameters().find(key);
  if (found == scan_parameters().end()) {
    std::string message = "no parameter \"" + std::string(key) + "\"; there are:";
    for (const auto& [name, setter] : scan_parameters()) message += " " + std::string(name);
    return invalid(std::move(message));
  }
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size()) {
    return invalid(std::string(key) + ": \"" + std::string(value) + "\" is not a number");
  }
  ScanBuilder changed = builder;
  found->second(changed, number);
  if (const auto complaint = changed.check()) return invalid(*complaint);
  builder = changed;
  return {};
}

}  // namespace

std::vector<std::string_view> builder_names() {
  std::vector<std::string_view> names;
  for (const Named& named : all_builders()) names.push_back(named.name);
  return names;
}

Result<AnyBuilder> make_builder(std::string_view name) {
  for (const Named& named : all_builders()) {
    if (named.name == name) return named.builder;
  }
  std::string message = "no builder \"" + std::string(name) + "\"; there are:";
  for (const std::string_view known : builder_names()) message += " " + std::string(known);
  return Error{Code::kInvalidArgument, std::move(message), "UNKNOWN_BUILDER"};
}

Status set_parameter(AnyBuilder& builder, std::string_view key, std::string_view value) {
  return std::visit([&](auto& b) { return set(b, key, value); }, builder);
}

}  // namespace sightline::accel
