// Builders and parameters by name.
#include "accel/published/any_builder.h"

#include <charconv>
#include <cmath>

namespace sightline::accel::published {
namespace {

struct Named {
  std::string_view name;
  AnyBuilder builder;
};

const std::vector<Named>& all_builders() {
  static const std::vector<Named> kBuilders = {
      {"spatial-median", KdBuilder(kd::SpatialMedianBuilder{})},
      {"object-median", KdBuilder(kd::ObjectMedianBuilder{})},
      {"sah-naive", KdBuilder(kd::ExactBuilder{.search = kd::ExactSearch::kNaive})},
      {"sah-sort", KdBuilder(kd::ExactBuilder{.search = kd::ExactSearch::kSort})},
      {"sah-sweep", KdBuilder(kd::ExactBuilder{.search = kd::ExactSearch::kSweep})},
      {"min-max-bins", KdBuilder(kd::MinMaxBuilder{})},
      {"scan-one-axis", KdBuilder(kd::HuntScan{.axes = kd::ScanAxes::kOne})},
      {"scan-hybrid", KdBuilder(kd::HuntScan{.axes = kd::ScanAxes::kHybrid})},
      {"scan-all-axes", KdBuilder(kd::HuntScan{.axes = kd::ScanAxes::kAll})},
      {"scan-fast", KdBuilder(ScanBuilder(split::scan_fast()))},
      {"scan-best", KdBuilder(ScanBuilder(split::scan_best()))},
      {"bvh-sweep", bvh::BvhBuilder{.method = bvh::BvhMethod::kSweep}},
      {"bvh-binned",
       bvh::BvhBuilder{.method = bvh::BvhMethod::kBinned, .leaf = {.split_small = true}}},
      {"bvh-esc", bvh::BvhBuilder{.method = bvh::BvhMethod::kEarly}},
      {"bvh-evh", bvh::BvhBuilder{.method = bvh::BvhMethod::kEdgeVolume}},
      {"sbvh", bvh::BvhBuilder{.method = bvh::BvhMethod::kSpatial}},
  };
  return kBuilders;
}

Error invalid(std::string message) {
  return {Code::kInvalidArgument, std::move(message), "BUILDER_PARAMETER"};
}

/// A parameter: its name, and the member of the builder. The type of the member says whether it is
/// a number, a count or a switch. One name may set several members.
template <class Builder>
struct Parameter {
  template <class T>
  using Field = T& (*)(Builder&);

  std::string_view name;
  std::variant<Field<double>, Field<std::uint32_t>, Field<bool>> field;
};

template <class Builder>
using Parameters = std::vector<Parameter<Builder>>;

const Parameters<ScanBuilder>& parameters(const ScanBuilder&) {
  using B = ScanBuilder;
  static const Parameters<B> kParameters = {
      {"samples", [](B& b) -> std::uint32_t& { return b.uniform_samples; }},
      {"uniform_samples", [](B& b) -> std::uint32_t& { return b.uniform_samples; }},
      {"exact_below", [](B& b) -> std::uint32_t& { return b.exact_below; }},
      {"hybrid_below", [](B& b) -> std::uint32_t& { return b.all_axes_up_to; }},
      {"cost_traverse", [](B& b) -> double& { return b.cost.traverse; }},
      {"cost_intersect", [](B& b) -> double& { return b.cost.intersect; }},
      {"empty_bonus", [](B& b) -> double& { return b.cost.empty_bonus; }},
      {"retry_above", [](B& b) -> double& { return b.retry_above; }},
      {"refine_all_axes", [](B& b) -> bool& { return b.refine_all_axes; }},
      {"clip", [](B& b) -> bool& { return b.clip; }},
      {"clip_crowds", [](B& b) -> bool& { return b.clip_dense; }},
      {"budget", [](B& b) -> double& { return b.budget; }},
      {"blocks", [](B& b) -> bool& { return b.blocks; }},
  };
  return kParameters;
}

const Parameters<kd::HuntScan>& parameters(const kd::HuntScan&) {
  using B = kd::HuntScan;
  static const Parameters<B> kParameters = {
      {"samples", [](B& b) -> std::uint32_t& { return b.uniform_samples; }},
      {"samples", [](B& b) -> std::uint32_t& { return b.adaptive_samples; }},
      {"uniform_samples", [](B& b) -> std::uint32_t& { return b.uniform_samples; }},
      {"adaptive_samples", [](B& b) -> std::uint32_t& { return b.adaptive_samples; }},
      {"exact_below", [](B& b) -> std::uint32_t& { return b.exact_below; }},
      {"hybrid_below", [](B& b) -> std::uint32_t& { return b.hybrid_below; }},
      {"cost_traverse", [](B& b) -> double& { return b.cost.traverse; }},
      {"cost_intersect", [](B& b) -> double& { return b.cost.intersect; }},
      {"empty_bonus", [](B& b) -> double& { return b.cost.empty_bonus; }},
      {"retry_above", [](B& b) -> double& { return b.retry_above; }},
      {"snap", [](B& b) -> bool& { return b.snap; }},
      {"clip", [](B& b) -> bool& { return b.clip; }},
  };
  return kParameters;
}

template <class B>
const Parameters<B>& median_parameters() {
  static const Parameters<B> kParameters = {
      {"leaf_size", [](B& b) -> std::uint32_t& { return b.stop.leaf_size; }},
      {"max_depth", [](B& b) -> std::uint32_t& { return b.stop.max_depth; }},
  };
  return kParameters;
}

const Parameters<kd::SpatialMedianBuilder>& parameters(const kd::SpatialMedianBuilder&) {
  return median_parameters<kd::SpatialMedianBuilder>();
}

const Parameters<kd::ObjectMedianBuilder>& parameters(const kd::ObjectMedianBuilder&) {
  return median_parameters<kd::ObjectMedianBuilder>();
}

const Parameters<kd::ExactBuilder>& parameters(const kd::ExactBuilder&) {
  using B = kd::ExactBuilder;
  static const Parameters<B> kParameters = {
      {"cost_traverse", [](B& b) -> double& { return b.costs.traverse; }},
      {"cost_intersect", [](B& b) -> double& { return b.costs.intersect; }},
      {"lambda", [](B& b) -> double& { return b.costs.lambda; }},
      {"bad_refines", [](B& b) -> std::uint32_t& { return b.bad_refines; }},
      {"clip", [](B& b) -> bool& { return b.clip; }},
  };
  return kParameters;
}

const Parameters<kd::MinMaxBuilder>& parameters(const kd::MinMaxBuilder&) {
  using B = kd::MinMaxBuilder;
  static const Parameters<B> kParameters = {
      {"bins", [](B& b) -> std::uint32_t& { return b.bins; }},
      {"subsample", [](B& b) -> bool& { return b.subsample; }},
      {"threads", [](B& b) -> std::uint32_t& { return b.threads; }},
      {"cost_traverse", [](B& b) -> double& { return b.cost.traverse; }},
      {"cost_intersect", [](B& b) -> double& { return b.cost.intersect; }},
      {"empty_bonus", [](B& b) -> double& { return b.cost.empty_bonus; }},
  };
  return kParameters;
}

/// Returns the parameters of all hierarchies, then the ones of one method.
Parameters<bvh::BvhBuilder> bvh_parameters(Parameters<bvh::BvhBuilder> own) {
  using B = bvh::BvhBuilder;
  Parameters<B> parameters = {
      {"leaf_size", [](B& b) -> std::uint32_t& { return b.leaf.leaf_size; }},
      {"split_small", [](B& b) -> bool& { return b.leaf.split_small; }},
      {"cost_traverse", [](B& b) -> double& { return b.leaf.traverse; }},
      {"cost_intersect", [](B& b) -> double& { return b.leaf.intersect; }},
  };
  parameters.insert(parameters.end(), own.begin(), own.end());
  return parameters;
}

const Parameters<bvh::BvhBuilder>& parameters(const bvh::BvhBuilder& builder) {
  using B = bvh::BvhBuilder;
  static const Parameters<B> kSweep = bvh_parameters({});
  static const Parameters<B> kBinned =
      bvh_parameters({{"bins", [](B& b) -> std::uint32_t& { return b.bins; }}});
  static const Parameters<B> kPreSplit = bvh_parameters({
      {"threshold", [](B& b) -> double& { return b.pre_split.threshold; }},
      {"budget", [](B& b) -> double& { return b.pre_split.budget; }},
      {"repeats", [](B& b) -> bool& { return b.repeats; }},
  });
  static const Parameters<B> kSpatial = bvh_parameters({
      {"alpha", [](B& b) -> double& { return b.spatial.alpha; }},
      {"node_overlap", [](B& b) -> double& { return b.spatial.node_overlap; }},
      {"spatial_bins", [](B& b) -> std::uint32_t& { return b.spatial.bins; }},
      {"unsplit", [](B& b) -> bool& { return b.spatial.unsplit; }},
      {"budget", [](B& b) -> double& { return b.spatial.budget; }},
  });
  switch (builder.method) {
    case bvh::BvhMethod::kSweep:
      return kSweep;
    case bvh::BvhMethod::kBinned:
      return kBinned;
    case bvh::BvhMethod::kEarly:
    case bvh::BvhMethod::kEdgeVolume:
      return kPreSplit;
    case bvh::BvhMethod::kSpatial:
      break;
  }
  return kSpatial;
}

/// Parses a value of the field's type. On failure, returns a description of the expected values.
std::optional<std::string_view> read(std::string_view text, double& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (error == std::errc() && end == text.data() + text.size() && std::isfinite(out))
    return std::nullopt;
  return "a number";
}

std::optional<std::string_view> read(std::string_view text, std::uint32_t& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (error == std::errc() && end == text.data() + text.size()) return std::nullopt;
  return "a whole number of 0 to 4294967295";
}

std::optional<std::string_view> read(std::string_view text, bool& out) {
  const bool on = text == "on" || text == "1";
  if (!on && text != "off" && text != "0") return "on, off, 1 or 0";
  out = on;
  return std::nullopt;
}

template <class Builder>
Status set(Builder& builder, std::string_view key, std::string_view value) {
  Builder changed = builder;
  bool known = false;
  for (const Parameter<Builder>& parameter : parameters(builder)) {
    if (parameter.name != key) continue;
    known = true;
    const auto expected =
        std::visit([&](auto field) { return read(value, field(changed)); }, parameter.field);
    if (expected) {
      return invalid(std::string(key) + ": \"" + std::string(value) + "\" is not " +
                     std::string(*expected));
    }
  }
  if (!known) {
    std::string message = "no parameter \"" + std::string(key) + "\"; there are:";
    std::string_view last;
    for (const Parameter<Builder>& parameter : parameters(builder)) {
      if (parameter.name != last) message += " " + std::string(parameter.name);
      last = parameter.name;
    }
    return invalid(std::move(message));
  }
  if (const auto complaint = changed.check()) return invalid(*complaint);
  builder = changed;
  return {};
}

}  // namespace

AnyBuilder default_builder() { return KdBuilder(ScanBuilder(split::scan_fast())); }

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
  if (auto* bvh = std::get_if<bvh::BvhBuilder>(&builder)) return set(*bvh, key, value);
  return std::visit([&](auto& b) { return set(b, key, value); }, std::get<KdBuilder>(builder));
}

}  // namespace sightline::accel::published
