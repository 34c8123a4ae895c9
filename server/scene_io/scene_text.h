// A scene in protobuf text format: parsed, with the place of each field remembered, so that what is
// found wrong later still names its line. Offline.
#pragma once

#include <google/protobuf/text_format.h>

#include <string>
#include <string_view>

#include "hapticd/v1/scene.pb.h"
#include "server/scene_io/scene_problem.h"

namespace hapticd {

/// Longest text of a scene, bytes: what fits into one blob of the protocol.
inline constexpr std::size_t kLongestSceneText = 4'194'000;

class SceneText {
 public:
  /// Parses `text`, which came from `file`. What is not a Scene is in problems().
  SceneText(std::string_view text, std::string file);

  /// Empty when the text is a Scene; its numbers may still be out of range.
  [[nodiscard]] const SceneProblems& problems() const noexcept { return problems_; }

  /// As written.
  [[nodiscard]] const v1::Scene& scene() const noexcept { return scene_; }
  [[nodiscard]] const std::string& file() const noexcept { return file_; }

  /// `problem` with the file, and the line and column of its field; of the message it is missing in
  /// when it is not written.
  [[nodiscard]] SceneProblem located(SceneProblem problem) const;

 private:
  std::string file_;
  v1::Scene scene_;
  google::protobuf::TextFormat::ParseInfoTree places_;
  SceneProblems problems_;
};

}  // namespace hapticd
