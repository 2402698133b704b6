// What is asked about the sides of points, before it is sent. Internal to the library.
#pragma once

#include "client/cast_options.h"
#include "client/result.h"

namespace sightline::client::calls {

/// Of a query of points. Errors: kInvalidArgument, with the reason that a server gives.
Status check_sides(const CastOptions& options, HitFields fields);

/// Of a cast of rays, which have no sides. Errors: as check_sides().
Status check_no_sides(const CastOptions& options, HitFields fields);

/// Whether the options say how sides are found.
bool has_sides(const CastOptions& options);

/// The options of a query without rows. Its columns are all empty, so that none asks for a side.
CastOptions without_sides(CastOptions options);

}  // namespace sightline::client::calls
