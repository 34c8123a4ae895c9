// What hapticd gives up once it has what it needs: new privileges, capabilities, and the system
// calls that the role of a thread has no use for. A peer that takes a thread over gets no more than
// that. Each thread gives up its own as it begins (core/rt/thread_role.h). Not RT.
#pragma once

#include <cstdint>
#include <string>

namespace hapticd {

/// What becomes of a call outside the table.
enum class Confinement : std::uint8_t {
  kOff,     ///< it is made: for debuggers, and drivers that nobody knows yet
  kOn,      ///< it fails as if the kernel did not know it (ENOSYS): libraries then do as they did
            ///< before there was such a call, and a player plays on
  kStrict,  ///< the process says which call of which thread it was, and ends: for tests
};

/// Before begin_confinement(); kOn otherwise.
void choose_confinement(Confinement how) noexcept;

/// No thread of the process gets new privileges from here on, and those that begin with a role
/// (begin_role) are confined to it; once, before there are others. Returns what is not given up,
/// although it should be, and why, for people; empty: nothing. A build with a sanitizer, and a
/// kernel that refuses, confine nothing. May throw std::bad_alloc.
[[nodiscard]] std::string begin_confinement();

}  // namespace hapticd
