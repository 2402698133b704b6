// Checks the answers of packets that walk through trees of a case's triangles.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "accel/wide/float_rays.h"
#include "accel/wide/packet.h"
#include "tests/fuzz/verdict/exact_answers.h"
#include "tests/fuzz/verdict/verdict_case.h"
#include "tests/fuzz/verdict/verdict_tree.h"

namespace sightline::tests {

struct PreparedPacket {
  std::unique_ptr<accel::wide::Packet> packet = std::make_unique<accel::wide::Packet>();
  std::unique_ptr<accel::wide::BestHits> best = std::make_unique<accel::wide::BestHits>();
};

/// Sets a packet to the rays of a case and the hits that they come with; `any`: without those.
/// Returns those that are live.
std::uint32_t prepare_packet(const VerdictCase& asked, const VerdictTree& tree, bool any,
                             PreparedPacket& out);

/// Nearest, any and every hit, all rays together and each alone, equal the hit rule. Describes what
/// is wrong.
std::optional<std::string> check_packets(const VerdictCase& asked, const VerdictTree& tree,
                                         const ExactAnswers& exact);

}  // namespace sightline::tests
