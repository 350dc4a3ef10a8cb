// How functions of c.h fail: a status, and a message kept by thread in room of a fixed size, so
// that keeping it cannot fail in turn.
#include <array>
#include <cstdio>
#include <limits>
#include <shadowcut/version.hpp>

#include "handles.hpp"

namespace shadowcut::c {
namespace {

thread_local std::array<char, 1024> last_message{};

shadowcut_status failed(shadowcut_status status, const char* message) noexcept {
  std::snprintf(last_message.data(), last_message.size(), "%s", message);
  return status;
}

}  // namespace

void fail(shadowcut_status status, std::string message) {
  throw Failure{status, std::move(message)};
}

shadowcut_status status_of_exception() noexcept {
  try {
    throw;
  } catch (const Failure& failure) {
    return failed(failure.status, failure.message.c_str());
  } catch (const Error& error) {
    return failed(SHADOWCUT_REFUSED, error.what());
  } catch (const std::bad_alloc&) {
    return failed(SHADOWCUT_OUT_OF_MEMORY, "out of memory");
  } catch (const std::length_error&) {  // more than any memory has
    return failed(SHADOWCUT_OUT_OF_MEMORY, "out of memory");
  } catch (const std::exception& error) {
    return failed(SHADOWCUT_INTERNAL_ERROR, error.what());
  } catch (...) {
    return failed(SHADOWCUT_INTERNAL_ERROR, "an exception of an unknown type");
  }
}

std::uint32_t count_of(std::size_t size) {
  if (size > std::numeric_limits<std::uint32_t>::max())
    fail(SHADOWCUT_REFUSED, "a count does not fit into 32 bits");
  return static_cast<std::uint32_t>(size);
}

}  // namespace shadowcut::c

const char* shadowcut_message(void) { return shadowcut::c::last_message.data(); }

const char* shadowcut_status_name(shadowcut_status status) {
  constexpr std::array names{
      "OK",        "INVALID_ARGUMENT", "REFUSED",      "STALE",         "FOREIGN",
      "NOT_FOUND", "OUT_OF_MEMORY",    "MUST_COMPACT", "INTERNAL_ERROR"};
  return status >= 0 && static_cast<std::size_t>(status) < names.size()
             ? names[static_cast<std::size_t>(status)]
             : "";
}

const char* shadowcut_version(void) { return shadowcut::version(); }
void shadowcut_version_numbers(uint32_t* major, uint32_t* minor, uint32_t* patch) {
  if (major) *major = SHADOWCUT_VERSION_MAJOR;
  if (minor) *minor = SHADOWCUT_VERSION_MINOR;
  if (patch) *patch = SHADOWCUT_VERSION_PATCH;
}
