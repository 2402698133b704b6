// A picture of one node's surface by its distance to everything else.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "client/cli/picture/film.h"
#include "client/cli/picture/scale.h"
#include "client/client.h"
#include "client/result.h"
#include "client/scene_info.h"

namespace sightline::client::cli::picture {

struct ClearanceRequest {
  std::uint64_t node = 0;         ///< it is drawn, with the nodes under it
  std::optional<double> range{};  ///< the distance with the last colour, in the scene's unit, above
                                  ///< 0; not set: the greatest of the picture
  bool with_context = false;      ///< the rest is drawn too, in grey, behind the node
};

/// What a picture tells of distances.
struct Clearance {
  CastReport report;  ///< rays and hits are those at the node
  Scale scale;
  /// The least and the greatest distance, in the scene's unit; not set if nothing is hit, or if
  /// there is nothing else in the scene.
  std::optional<ValueRange> distances{};
};

/// Casts the view at the node alone, so that nothing hides it, and asks for the distance of each
/// hit from the rest at the same revision. A surface that lies within another thing is as far from
/// it as from its faces. Errors: those of the casts; kOutOfRange, the scene changed so often
/// meanwhile that the revision is not kept any more. `progress`: as for render_picture.
Result<Clearance> paint_clearance(const Client& client, const SceneInfo& scene, Film& film,
                                  const ClearanceRequest& request, const Consistency& consistency,
                                  const std::function<void(double)>& progress);

}  // namespace sightline::client::cli::picture
