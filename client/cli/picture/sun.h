// A picture in the light of a sun: surfaces that it does not reach are in shadow.
#pragma once

#include <functional>
#include <string>

#include "client/cli/picture/film.h"
#include "client/client.h"
#include "client/result.h"

namespace sightline::client::cli::picture {

struct SunRequest {
  double scene_size = 1;  ///< the length of the diagonal of the scene's bounds
  Consistency consistency;
};

/// The unit direction to the sun, which stands high behind the camera at its left.
Vec3 direction_to_sun(const Camera& camera);

/// Casts the view, and then a ray to the sun from each surface that is turned to it. The report
/// counts all rays. `progress`: as for render_picture.
Result<CastReport> paint_in_sun(const Client& client, const std::string& scene, Film& film,
                                const SunRequest& request,
                                const std::function<void(double)>& progress);

}  // namespace sightline::client::cli::picture
