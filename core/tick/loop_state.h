// Where the loop stands. What leads from one state to another: core/safety/loop_state.h. Plain
// data. RT: yes.
#pragma once

#include <cstdint>

namespace hapticd {

/// Same numbers as hapticd::v1::LoopState.
enum class LoopState : std::uint8_t {
  kDetached = 1,
  kZeroing,
  kReady,
  kEngaged,
  kReleasing,
  kFault,
  kOver,
};

}  // namespace hapticd
