// Loads a gesture from a name, a file or a message: parsed, checked and filled in, or refused with
// every fault in it. gesture_motion.h says where its way-points lie. Offline.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hapticd/v1/gesture.pb.h"
#include "server/scene_io/scene_problem.h"

namespace hapticd {

/// Folders with gestures.
using GestureFolders = std::vector<std::filesystem::path>;

/// The folder `gestures` of the installation (installed_paths of model_files.h says where that is).
[[nodiscard]] GestureFolders installed_gestures();

struct GestureResult {
  std::optional<v1::Gesture> gesture;  ///< defaults filled in; none when there is a fault
  SceneProblems problems;
  bool missing = false;  ///< there is no such gesture: nothing could be read
};

/// `name` is that of an installed gesture, whoever gives it.
[[nodiscard]] GestureResult load_installed_gesture(const std::string& name,
                                                   const GestureFolders& folders);

/// `source` is the name of an installed gesture, or a file: with '/' or ".textproto" in it. For the
/// owner of the machine, not for peers.
[[nodiscard]] GestureResult load_gesture(const std::string& source, const GestureFolders& folders);

/// From a message; problems have the paths of its fields, and no file or line.
[[nodiscard]] GestureResult check_gesture(const v1::Gesture& gesture);

}  // namespace hapticd
