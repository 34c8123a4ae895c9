// What clients have been told strings sound like, for those who come later: the newest
// StringSounding of each string that sounds, which States repeat in StringState.sounding. It is
// gathered from the events as they are sent, so that neither ticks nor recordings hold it twice.
// Not RT.
#pragma once

#include <cstdint>
#include <map>

#include "hapticd/v1/stream.pb.h"

namespace hapticd {

class ToldSoundings {
 public:
  /// An event of scene `scene_id` that clients are told; anything but StringSounding is left alone.
  /// One of another scene than before ends what sounded in that.
  void take(std::uint32_t scene_id, const v1::Item& event);
  /// Adds to each listed string of `state` with index `first` or a greater one what it sounds like.
  /// A State of another scene than the newest event's is left as it is.
  void add_to(std::uint32_t first, v1::State& state) const;

 private:
  std::uint32_t scene_id_ = 0;
  std::map<std::uint32_t, v1::StringSounding> newest_;  ///< by string; silent ones are not there
};

}  // namespace hapticd
