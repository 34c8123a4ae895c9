// Seeds that no run before has had. Not RT.
#pragma once

#include <cstdint>
#include <random>

namespace hapticd::test {

/// A seed that no run before has had.
[[nodiscard]] inline std::uint64_t fresh_seed() {
  std::random_device device;
  return (static_cast<std::uint64_t>(device()) << 32U) | device();
}

}  // namespace hapticd::test
