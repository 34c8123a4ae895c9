// Gestures and device profiles from text that has no file; problems name it "inline". Not RT.
#pragma once

#include <string_view>

#include "server/scene_io/gesture_loader.h"
#include "server/scene_io/message_text.h"
#include "server/scene_io/profile_loader.h"

namespace hapticd::test {

[[nodiscard]] inline GestureResult load_gesture_text(std::string_view text) {
  return check_text(text, "inline", "gesture", check_gesture);
}

[[nodiscard]] inline ProfileResult load_profile_text(std::string_view text) {
  return check_text(text, "inline", "device profile", check_profile);
}

}  // namespace hapticd::test
