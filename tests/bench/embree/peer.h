// Embree 3 as a peer: the same arrays, rays and threads, answered by another library at its best.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

enum class EmbreeQuality : std::uint8_t { kLow, kMedium, kHigh };

struct EmbreeSettings {
  EmbreeQuality quality = EmbreeQuality::kMedium;
  /// RTC_SCENE_FLAG_ROBUST. It silently turns HIGH into MEDIUM, so there is no HIGH with it.
  bool robust = false;
  /// For count(): slower to trace.
  bool crossings = false;
};

/// The command line's names: embree-low, ..., embree-medium-robust.
std::span<const std::string_view> embree_names();
/// Nothing if it is none of them.
std::optional<EmbreeSettings> parse_embree(std::string_view name);

/// A mode of `lazy` alone: see EmbreePeer::make_lazy.
inline constexpr std::string_view kEmbreeLazy = "embree-lazy";

/// Whether this program was built with Embree 3. If not, EmbreePeer::make fails.
bool embree_found();

struct EmbreeBuilt {
  double commit_seconds = 0;  ///< rtcCommitScene alone, of every scene there is.
  double total_seconds = 0;   ///< With making scenes and geometries out of the arrays.
  std::uint64_t bytes_final = 0, bytes_peak = 0;  ///< As Embree tells; the arrays left out.
};

/// How much there is by now.
struct EmbreeGrown {
  std::uint64_t objects = 0;    ///< Of a lazy peer: those rays came upon. Else all.
  std::uint64_t triangles = 0;  ///< In trees, instances counted once.
  std::uint64_t bytes = 0;      ///< As Embree tells; the arrays left out.
  double seconds_in_trace = 0;  ///< Spent building while tracing, summed over threads.
};

/// One device and one scene at a time.
///
/// What is made ready by `make` and never timed: the device, and vertex arrays as Embree wants
/// them (shared with it, one vertex longer than ours, because it reads 16 bytes at the last one).
/// A mesh used once is laid in the world beforehand, if it does not lie there already: one level
/// is Embree's best. A mesh used more often is a scene of its own under instances.
/// Everything happens in a frame that turns with the first node, as our trees stay as they are
/// where a root is turned.
///
/// Denormals are flushed, as Embree advises, on its threads and only while it works.
/// Threads: one caller, in an oneTBB arena of `threads` threads.
class EmbreePeer {
 public:
  /// Errors: kFailedPrecondition where embree_found() is false; kInternal: what Embree says.
  static Result<std::unique_ptr<EmbreePeer>> make(const SceneSource& scene, EmbreeSettings settings,
                                                  int threads);
  /// Embree's own laziness, as its manual shows it: a user geometry for every node with a mesh, of
  /// which a build makes the bounds alone; the first ray that comes upon it builds a scene over the
  /// mesh (other threads join), and rays are traced in that. Of LOW and MEDIUM, within objects and
  /// over them, choose_entry keeps what is done first with the rays. Rays enter one by one. No
  /// count().
  static Result<std::unique_ptr<EmbreePeer>> make_lazy(const SceneSource& scene, int threads);
  virtual ~EmbreePeer() = default;

  /// Drops the scene and builds it anew. Errors: kInternal: what Embree says.
  virtual Result<EmbreeBuilt> build() = 0;

  /// Tries every entry point on blocks of these rays and keeps the fastest. After build().
  virtual void choose_entry(std::span<const accel::geometry::Ray> rays, bool any) = 0;
  /// E.g. "rtcIntersect16 coherent".
  virtual std::string entry() const = 0;

  /// Answers the rays, `batch` of them at a time (0: all at once), by the chosen entry point.
  /// Returns the seconds inside Embree: its ray buffers are filled before and read after.
  /// Of a hit only t, node, primitive and state are set; for `any` only the state.
  virtual double trace(std::span<const accel::geometry::Ray> rays, bool any,
                       std::span<accel::geometry::Hit> hits, std::size_t batch) = 0;

  virtual EmbreeGrown grown() const = 0;

  /// counts[i] is how many triangles rays[i] meets within its limits, each once. For settings with
  /// `crossings`; after build().
  virtual void count(std::span<const accel::geometry::Ray> rays,
                     std::span<std::uint32_t> counts) = 0;
};

}  // namespace sightline::bench
