// The number of the physics. RT: yes.
#pragma once

#include <cstdint>

namespace hapticd {

/// Grows with every version that computes another force from the same poses. Recordings carry it: a
/// replay of another number compares poses alone.
inline constexpr std::uint32_t kPhysics = 2;

}  // namespace hapticd
