// What is told of a cast that has ended.
#pragma once

#include <cstdio>
#include <optional>

#include "client/cli/session.h"
#include "client/cli/verbs/cast_file.h"
#include "client/scene_info.h"

namespace sightline::client::cli::verbs {

Json json_of_cast(const CastOutcome& outcome, QueryKind kind, const SceneStats& stats);

/// Prints what was cast, hit and built, in a few lines. Without `stats` it does not say how much of
/// the scene is built.
void print_cast_summary(std::FILE* to, const CastOutcome& outcome,
                        const std::optional<SceneStats>& stats);

/// Prints why rays could not be cast, that hits were cut off, and that float32 is too coarse.
void print_cast_warnings(const CastOutcome& outcome, const SceneInfo& scene);

/// Prints how many rays or points have no answer, if there are any.
void warn_of_unanswered(const CastReport& cast, files::RowKind asked);

}  // namespace sightline::client::cli::verbs
