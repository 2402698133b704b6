// Embree 3 as a peer: the same arrays, rays and threads, through Embree's fastest entry points.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

enum class EmbreeQuality : std::uint8_t { kLow, kMedium, kHigh };

struct EmbreeSettings {
  EmbreeQuality quality = EmbreeQuality::kMedium;
  /// RTC_SCENE_FLAG_ROBUST. It silently turns HIGH into MEDIUM, so there is no HIGH with it.
  bool robust = false;
  /// Needed by count(); slower to trace.
  bool crossings = false;
  /// Only rtcIntersect1 and rtcOccluded1, as callers with one ray at a time use Embree: no other
  /// entry point is tried.
  bool single = false;
};

/// The command line's names: embree-low, ..., embree-medium-robust-single.
std::span<const std::string_view> embree_names();
/// Nothing if `name` is none of them.
std::optional<EmbreeSettings> parse_embree(std::string_view name);

/// A mode of `lazy` only: see EmbreePeer::make_lazy.
inline constexpr std::string_view kEmbreeLazy = "embree-lazy";

/// Whether this program was built with Embree 3. If not, EmbreePeer::make fails.
bool embree_found();

struct EmbreeBuilt {
  double commit_seconds = 0;  ///< Time in rtcCommitScene, over all scenes.
  double total_seconds = 0;   ///< Also counts creating scenes and geometries from the arrays.
  std::uint64_t bytes_final = 0, bytes_peak = 0;  ///< As Embree reports; without the arrays.
};

/// What has been built so far.
struct EmbreeGrown {
  std::uint64_t objects = 0;    ///< Lazy peer: objects that rays have reached. Otherwise all.
  std::uint64_t triangles = 0;  ///< In trees; instances counted once.
  std::uint64_t bytes = 0;      ///< As Embree reports; without the arrays.
  double seconds_in_trace = 0;  ///< Time spent building while tracing, summed over threads.
};

/// One device and one scene at a time.
///
/// `make` prepares, untimed: the device, and vertex arrays as Embree needs them (shared with it,
/// one vertex longer than ours, because it reads 16 bytes at the last one). A mesh used once is
/// transformed to world space beforehand: one level is Embree's best case. A mesh used more often
/// is a scene of its own under instances. All coordinates are in a frame that rotates with the
/// first node, as our trees do not change when a root is rotated.
///
/// Denormals are flushed, as Embree advises, on its threads and only while it works.
/// Threads: one caller, in an oneTBB arena of `threads` threads.
class EmbreePeer {
 public:
  /// Errors: kFailedPrecondition if embree_found() is false; kInternal: Embree's error.
  static Result<std::unique_ptr<EmbreePeer>> make(const SceneSource& scene, EmbreeSettings settings,
                                                  int threads);
  /// Embree's own laziness, as in its manual: one user geometry for every node with a mesh. A build
  /// computes only its bounds; the first ray that reaches it builds a scene over the mesh (other
  /// threads join), in which rays are traced. choose_entry tries LOW and MEDIUM, within objects and
  /// above them, and keeps the fastest for the rays. Single rays only. No count() and nearest().
  static Result<std::unique_ptr<EmbreePeer>> make_lazy(const SceneSource& scene, int threads);
  virtual ~EmbreePeer() = default;

  /// Drops the scene and builds a new one. Errors: kInternal: Embree's error.
  virtual Result<EmbreeBuilt> build() = 0;

  /// Tries every entry point on blocks of these rays and keeps the fastest; with the setting
  /// `single` there is only one. Call after build().
  virtual void choose_entry(std::span<const accel::geometry::Ray> rays, bool any) = 0;
  /// E.g. "rtcIntersect16 coherent".
  virtual std::string entry() const = 0;

  /// Traces the rays through the chosen entry point, `batch` at a time (0: all at once). Returns
  /// the seconds inside Embree: filling and reading ray buffers is not timed. Sets only t, node,
  /// primitive and state of a hit; for `any` only the state.
  virtual double trace(std::span<const accel::geometry::Ray> rays, bool any,
                       std::span<accel::geometry::Hit> hits, std::size_t batch) = 0;

  virtual EmbreeGrown grown() const = 0;

  /// Sets counts[i] to the number of distinct triangles that rays[i] meets within its limits.
  /// Requires the setting `crossings`. Call after build().
  virtual void count(std::span<const accel::geometry::Ray> rays,
                     std::span<std::uint32_t> counts) = 0;

  /// Finds the face nearest to each point: sets t (the distance), node and primitive. Returns the
  /// seconds inside Embree. Requires a scene without meshes that several nodes have. Call after
  /// build().
  virtual double nearest(std::span<const accel::geometry::Vec3d> points,
                         std::span<accel::geometry::Hit> hits) = 0;
};

}  // namespace sightline::bench
