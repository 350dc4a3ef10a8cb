#include <shadowcut/version.hpp>

namespace shadowcut {

const char* version() { return SHADOWCUT_VERSION_STRING; }

}  // namespace shadowcut
