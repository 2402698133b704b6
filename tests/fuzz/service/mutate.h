// Changes sessions at random, message by message and field by field.
#pragma once

#include "tests/fuzz/service/session.h"
#include "tests/support/random.h"

namespace sightline::tests {

/// Changes one place of the session: a field of a message, a message, or a call.
void mutate(Session& session, Random& random);

}  // namespace sightline::tests
