// What may be on its way to the haptic loop, judged by the words of server/haptic_loop alone: every
// command, pose, gesture and change that requests have put into its rings. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>

#include "server/haptic_loop/loop_channels.h"

namespace hapticd::test {

/// The scene that a request means, and the time at which it came.
struct LoopPlace {
  std::size_t tools = 0;
  std::size_t pieces = 0;  ///< of string
  std::uint64_t next_tick = 0;
  std::uint64_t lease_ends = 0;
};

class LoopJudge {
 public:
  /// Looks at all that waits for the loop, which nobody may take meanwhile, and leaves it there.
  /// Throws std::logic_error where the loop would get what it must not.
  void look(LoopChannels& channels, const LoopPlace& place);

 private:
  void judge(const LoopCommand& command, const LoopPlace& place);

  std::uint64_t last_number_ = 0;
  std::uint64_t lease_ends_ = 0;
};

/// That a tick is finite, with forces that its devices were promised.
void judge_tick(const Tick& tick, const PlayedScene& scene);

}  // namespace hapticd::test
