// A scene in protobuf text format: parsed, with the place of each field remembered, so that what is
// found wrong later still names its line. Offline.
#pragma once

#include <string>
#include <string_view>

#include "hapticd/v1/scene.pb.h"
#include "server/scene_io/message_text.h"
#include "server/scene_io/scene_problem.h"

namespace hapticd {

/// Longest text of a scene, bytes: what fits into one blob of the protocol.
inline constexpr std::size_t kMaxSceneText = kMaxText;

class SceneText {
 public:
  /// Parses `text`, which came from `file`. What is not a Scene is in problems().
  SceneText(std::string_view text, std::string file)
      : text_(text, std::move(file), "scene", scene_) {}

  /// Empty when the text is a Scene; its numbers may still be out of range.
  [[nodiscard]] const SceneProblems& problems() const noexcept { return text_.problems(); }

  /// As written.
  [[nodiscard]] const v1::Scene& scene() const noexcept { return scene_; }
  [[nodiscard]] const std::string& file() const noexcept { return text_.file(); }

  /// `problem` with the file, and the line and column of its field; of the message it is missing in
  /// when it is not written.
  [[nodiscard]] SceneProblem located(SceneProblem problem) const {
    return text_.located(std::move(problem));
  }

 private:
  v1::Scene scene_;
  MessageText text_;  // after what it parses into
};

}  // namespace hapticd
