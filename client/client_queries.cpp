// Casts of rays, and queries of points.
#include "client/calls/cast.h"
#include "client/client.h"

namespace sightline::client {

Result<CastReport> Client::cast(const std::string& scene, const RayColumns<const double>& rays,
                                const HitColumns& hits, const CastOptions& options) const {
  return calls::cast(*connection_, scene, rays, hits, options);
}
Result<CastReport> Client::cast(const std::string& scene, const RayColumns<const float>& rays,
                                const HitColumns& hits, const CastOptions& options) const {
  return calls::cast(*connection_, scene, rays, hits, options);
}

Result<AppliedCast> Client::apply_and_cast(const std::string& scene,
                                           std::span<const Update> updates,
                                           const RayColumns<const double>& rays,
                                           const HitColumns& hits, const CastOptions& options,
                                           const ApplyOptions& apply_options) const {
  return calls::apply_and_cast(*connection_, scene, updates, rays, hits, options, apply_options);
}
Result<AppliedCast> Client::apply_and_cast(const std::string& scene,
                                           std::span<const Update> updates,
                                           const RayColumns<const float>& rays,
                                           const HitColumns& hits, const CastOptions& options,
                                           const ApplyOptions& apply_options) const {
  return calls::apply_and_cast(*connection_, scene, updates, rays, hits, options, apply_options);
}

Result<CastReport> Client::cast_stream(const std::string& scene,
                                       const RayColumns<const double>& rays, const HitColumns& hits,
                                       const CastOptions& options) const {
  return calls::cast_stream(*connection_, scene, rays, hits, options);
}
Result<CastReport> Client::cast_stream(const std::string& scene,
                                       const RayColumns<const float>& rays, const HitColumns& hits,
                                       const CastOptions& options) const {
  return calls::cast_stream(*connection_, scene, rays, hits, options);
}
Result<CastReport> Client::cast_stream(const std::string& scene, const RaySource<double>& source,
                                       RayShape shape, HitFields fields, const HitSink& sink,
                                       const CastOptions& options) const {
  return calls::cast_source(*connection_, scene, source, shape, fields, sink, options);
}
Result<CastReport> Client::cast_stream(const std::string& scene, const RaySource<float>& source,
                                       RayShape shape, HitFields fields, const HitSink& sink,
                                       const CastOptions& options) const {
  return calls::cast_source(*connection_, scene, source, shape, fields, sink, options);
}

Result<CastReport> Client::cast_stream(const std::string& scene, const RayGenerator& generator,
                                       const HitColumns& hits, const CastOptions& options) const {
  return calls::cast_generated(*connection_, scene, generator, hits, options);
}
Result<CastReport> Client::cast_stream(const std::string& scene, const RayGenerator& generator,
                                       HitFields fields, const HitSink& sink,
                                       const CastOptions& options) const {
  return calls::cast_generated(*connection_, scene, generator, fields, sink, options);
}

Result<AllHits> Client::cast_all(const std::string& scene, const RayColumns<const double>& rays,
                                 HitFields fields, const CastOptions& options) const {
  return calls::cast_all(*connection_, scene, rays, fields, options);
}
Result<AllHits> Client::cast_all(const std::string& scene, const RayColumns<const float>& rays,
                                 HitFields fields, const CastOptions& options) const {
  return calls::cast_all(*connection_, scene, rays, fields, options);
}

Result<CastReport> Client::nearest(const std::string& scene,
                                   const PointColumns<const double>& points, const HitColumns& hits,
                                   const CastOptions& options) const {
  return calls::cast(*connection_, scene, points, hits, options);
}
Result<CastReport> Client::nearest(const std::string& scene,
                                   const PointColumns<const float>& points, const HitColumns& hits,
                                   const CastOptions& options) const {
  return calls::cast(*connection_, scene, points, hits, options);
}

Result<AppliedCast> Client::apply_and_nearest(const std::string& scene,
                                              std::span<const Update> updates,
                                              const PointColumns<const double>& points,
                                              const HitColumns& hits, const CastOptions& options,
                                              const ApplyOptions& apply_options) const {
  return calls::apply_and_cast(*connection_, scene, updates, points, hits, options, apply_options);
}
Result<AppliedCast> Client::apply_and_nearest(const std::string& scene,
                                              std::span<const Update> updates,
                                              const PointColumns<const float>& points,
                                              const HitColumns& hits, const CastOptions& options,
                                              const ApplyOptions& apply_options) const {
  return calls::apply_and_cast(*connection_, scene, updates, points, hits, options, apply_options);
}

Result<CastReport> Client::nearest_stream(const std::string& scene,
                                          const PointColumns<const double>& points,
                                          const HitColumns& hits,
                                          const CastOptions& options) const {
  return calls::cast_stream(*connection_, scene, points, hits, options);
}
Result<CastReport> Client::nearest_stream(const std::string& scene,
                                          const PointColumns<const float>& points,
                                          const HitColumns& hits,
                                          const CastOptions& options) const {
  return calls::cast_stream(*connection_, scene, points, hits, options);
}
Result<CastReport> Client::nearest_stream(const std::string& scene,
                                          const PointSource<double>& source, PointShape shape,
                                          HitFields fields, const HitSink& sink,
                                          const CastOptions& options) const {
  return calls::cast_source(*connection_, scene, source, shape, fields, sink, options);
}
Result<CastReport> Client::nearest_stream(const std::string& scene,
                                          const PointSource<float>& source, PointShape shape,
                                          HitFields fields, const HitSink& sink,
                                          const CastOptions& options) const {
  return calls::cast_source(*connection_, scene, source, shape, fields, sink, options);
}

Result<CastReport> Client::nearest_stream(const std::string& scene, const PointGrid& grid,
                                          const HitColumns& hits,
                                          const CastOptions& options) const {
  return calls::cast_generated(*connection_, scene, grid, hits, options);
}
Result<CastReport> Client::nearest_stream(const std::string& scene, const PointGrid& grid,
                                          HitFields fields, const HitSink& sink,
                                          const CastOptions& options) const {
  return calls::cast_generated(*connection_, scene, grid, fields, sink, options);
}

Result<AllHits> Client::nearest_all(const std::string& scene,
                                    const PointColumns<const double>& points, HitFields fields,
                                    const CastOptions& options) const {
  return calls::cast_all(*connection_, scene, points, fields, options);
}
Result<AllHits> Client::nearest_all(const std::string& scene,
                                    const PointColumns<const float>& points, HitFields fields,
                                    const CastOptions& options) const {
  return calls::cast_all(*connection_, scene, points, fields, options);
}

}  // namespace sightline::client
