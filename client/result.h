// What the client library returns: a value, or an error of the server, of the way there or of the
// arguments.
#pragma once

#include "proto/result.h"

namespace sightline::client {

using sightline::Code;
using sightline::Error;
using sightline::Result;
using sightline::Status;

}  // namespace sightline::client
