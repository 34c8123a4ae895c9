// Replays a fuzz target without a fuzzer: every file of its corpus, then mutations of them, always
// the same ones.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace hapticd::test {

/// A fuzz target: throws std::logic_error when the code under test does what it must not; returns
/// whether it took the bytes.
using FuzzTarget = std::function<bool(std::span<const std::uint8_t>)>;

struct Replay {
  std::int64_t inputs = 0;
  std::int64_t taken = 0;  ///< inputs the target did not refuse
};

/// All files of tests/fuzz/corpus/`name` (at least one, else std::runtime_error), sorted by name,
/// then `mutations` inputs derived from them: bytes changed, runs removed, repeated, spliced.
Replay replay(const std::string& name, std::int64_t mutations, const FuzzTarget& target);

}  // namespace hapticd::test
