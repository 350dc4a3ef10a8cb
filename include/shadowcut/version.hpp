/// @file
/// The version: SHADOWCUT_VERSION_MAJOR, _MINOR, _PATCH and SHADOWCUT_VERSION_STRING are those of
/// the headers; version() returns that of the library.
#pragma once

#include <shadowcut/version.h>

namespace shadowcut {

/// The version of the library that the program is linked with, such as "0.1.0". Never null.
const char* version();

}  // namespace shadowcut
