// Takes away from this process all that reading a scene file does not need.
#pragma once

namespace sightline::client::importer::sandbox {

/// The only descriptors of a confined process, apart from the standard streams, which lead to
/// /dev/null.
inline constexpr int kChannel = 3;
inline constexpr int kResult = 4;

/// Confines this process, which was just forked by `parent`. Afterwards it can compute, map memory
/// that is not executable, and use its descriptors: it cannot open a file or a socket, start a
/// process or a thread, or touch another process, and it ends with its parent. sched_yield() ends
/// it with SIGSYS: StuckWatch says why. Returns null, or what the system cannot do.
const char* confine(int parent, int channel, int result);

}  // namespace sightline::client::importer::sandbox
