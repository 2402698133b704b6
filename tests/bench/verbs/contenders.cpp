// The builders that --builder names.
#include "tests/bench/verbs/contenders.h"
#include "accel/published/any_builder.h"

#include <fmt/core.h>

#include <cstdio>

namespace sightline::bench {
namespace {

Error invalid(std::string message) {
  return {Code::kInvalidArgument, std::move(message), "COMMAND_LINE"};
}

Status set_pair(accel::published::AnyBuilder& builder, std::string_view pair) {
  const std::size_t equals = pair.find('=');
  if (equals == std::string_view::npos) {
    return invalid(fmt::format("builder parameter \"{}\" is not key=value", pair));
  }
  return accel::published::set_parameter(builder, pair.substr(0, equals), pair.substr(equals + 1));
}

}  // namespace

bool embree_is_missing(std::string_view name) {
  if (embree_found()) return false;
  fmt::print(stderr,
             "sightline-bench: no row for {}: built without Embree 3 (Debian: libembree-dev)\n",
             name);
  return true;
}

Result<std::vector<Contender>> parse_contenders(const std::vector<std::string>& names,
                                                const CommonOptions& common) {
  std::vector<Contender> contenders;
  for (const std::string& name : names) {
    if (const auto embree = parse_embree(name)) {
      if (!embree_is_missing(name)) contenders.push_back({name, *embree});
      continue;
    }
    const auto builder = configured_builder(name, common);
    if (!builder.ok()) return builder.error();
    contenders.push_back({name, *builder});
  }
  if (contenders.empty()) {
    return Error{Code::kFailedPrecondition, "no builder is left to measure", "NO_BUILDER"};
  }
  return contenders;
}

Result<accel::published::AnyBuilder> configured_builder(const std::string& text,
                                                        const CommonOptions& common) {
  const std::size_t question = text.find('?');
  const std::string name = text.substr(0, question);
  auto builder = name.empty()
                     ? Result<accel::published::AnyBuilder>(accel::published::default_builder())
                     : accel::published::make_builder(name);
  if (!builder.ok()) return builder.error();
  for (const std::string& pair : common.set) {
    if (auto set = set_pair(*builder, pair); !set.ok()) return set.error();
  }
  std::string_view rest;
  if (question != std::string::npos) rest = std::string_view(text).substr(question + 1);
  while (!rest.empty()) {
    const std::size_t end = rest.find('&');
    if (auto set = set_pair(*builder, rest.substr(0, end)); !set.ok()) return set.error();
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
  return builder;
}

std::optional<BuildCosts> build_costs(const accel::published::AnyBuilder& builder) {
  if (const auto* bvh = std::get_if<accel::published::bvh::BvhBuilder>(&builder))
    return BuildCosts{bvh->leaf.traverse, bvh->leaf.intersect};
  return std::visit(
      [](const auto& b) -> std::optional<BuildCosts> {
        if constexpr (requires { b.cost.traverse; }) {
          return BuildCosts{b.cost.traverse, b.cost.intersect};
        } else if constexpr (requires { b.costs.traverse; }) {
          return BuildCosts{b.costs.traverse, b.costs.intersect};
        } else {
          return std::nullopt;
        }
      },
      std::get<accel::published::KdBuilder>(builder));
}

Result<std::vector<std::unique_ptr<EmbreePeer>>> open_peers(
    const std::vector<Contender>& contenders, const SceneSource& scene, int threads) {
  std::vector<std::unique_ptr<EmbreePeer>> peers;
  for (const Contender& contender : contenders) {
    peers.push_back(nullptr);
    if (contender.embree() == nullptr) continue;
    auto peer = EmbreePeer::make(scene, *contender.embree(), threads);
    if (!peer.ok()) return peer.error();
    if (auto warm = (*peer)->build(); !warm.ok()) return warm.error();
    peers.back() = std::move(peer).value();
  }
  return peers;
}

}  // namespace sightline::bench
