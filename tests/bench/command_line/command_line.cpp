// The verbs of sightline-bench, with their options.
#include "tests/bench/command_line/command_line.h"

#include "tests/bench/command_line/shared_options.h"

namespace sightline::bench {

Verbs add_verbs(CLI::App& app) {
  Verbs all = add_tree_verbs(app);
  all.merge(add_motion_verbs(app));
  all.merge(add_answer_verbs(app));
  return all;
}

}  // namespace sightline::bench
