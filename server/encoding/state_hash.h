// The chained hash of RunResult: h_0 = 32 zero bytes, h_n = BLAKE2b-256(h_(n-1) | c_n) with c_n the
// canonical State of tick n. Two runs with equal hashes had equal States in every tick. Not RT;
// about 10 us a tick.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "server/encoding/encode_state.h"

namespace hapticd {

/// The chain so far.
struct StateHash {
  std::array<std::uint8_t, 32> hash{};
  v1::State state;    ///< memory of the last canonical State
  std::string bytes;  ///< and of its encoding
};

/// Takes the next tick into the chain; `complete` adds to its State what clients are told and no
/// tick knows.
void add_state(const Tick& tick, const SceneIndex& index,
               const std::function<void(v1::State&)>& complete, StateHash& chain);

}  // namespace hapticd
