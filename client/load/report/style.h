// How the page looks.
#pragma once

namespace sightline::client::load::report {

/// CSS: light and dark as the reader prefers, narrow screens, print.
extern const char* const kStyle;

}  // namespace sightline::client::load::report
