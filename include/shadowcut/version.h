/* The version of shadowcut's headers, for C and C++. A library may be of another version:
 * shadowcut_version() (c.h) and shadowcut::version() (version.hpp) return the version of the
 * library that the program runs with. */
#ifndef SHADOWCUT_VERSION_H
#define SHADOWCUT_VERSION_H

#define SHADOWCUT_VERSION_MAJOR 0
#define SHADOWCUT_VERSION_MINOR 1
#define SHADOWCUT_VERSION_PATCH 0
#define SHADOWCUT_VERSION_STRING "0.1.0"

#endif
