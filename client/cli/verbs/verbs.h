// The verbs of the command. Each adds itself and its options to the program, and runs at the end of
// parsing.
#pragma once

#include <string>
#include <vector>

#include "client/cli/session.h"

namespace CLI {
class App;
}

namespace sightline::client::cli::verbs {

void add_scene_verbs(CLI::App& program, Session& session);
/// `group` is the verb `scene`.
void add_import_verb(CLI::App& group, Session& session);
/// `group` is the verb `scene`.
void add_scene_add_verb(CLI::App& group, Session& session);
/// `group` is the verb `scene`.
void add_scene_export_verb(CLI::App& group, Session& session);
void add_server_verb(CLI::App& program, Session& session);
/// Adds `rtrace`, whose flags are those of another program.
void add_rtrace_verb(CLI::App& program, Session& session);
void add_backup_verbs(CLI::App& program, Session& session);
void add_cast_verb(CLI::App& program, Session& session);
void add_completion_verb(CLI::App& program, Session& session);
void add_load_verb(CLI::App& program, Session& session);
void add_nearest_verb(CLI::App& program, Session& session);
void add_prefetch_verb(CLI::App& program, Session& session);
void add_render_verb(CLI::App& program, Session& session);
void add_slice_verb(CLI::App& program, Session& session);
void add_stats_verb(CLI::App& program, Session& session);
void add_stream_verb(CLI::App& program, Session& session);
void add_update_verb(CLI::App& program, Session& session);
void add_watch_verb(CLI::App& program, Session& session);

}  // namespace sightline::client::cli::verbs
