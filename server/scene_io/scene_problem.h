// What is wrong, or doubtful, in a scene, and where: for people who write scenes. Offline.
#pragma once

#include <string>
#include <vector>

namespace hapticd {

struct SceneProblem {
  bool doubt = false;   ///< the scene can be played all the same
  std::string file;     ///< as it was named; "inline" for text without a file
  int line = 0;         ///< counts from 1; 0: nowhere in particular
  int column = 0;       ///< counts from 1
  std::string field;    ///< path below Scene; empty where the text itself cannot be read
  std::string message;  ///< what it is and what it may be
  std::string remedy;   ///< a sentence; may be empty
};

using SceneProblems = std::vector<SceneProblem>;

/// "file:12:3: error: strings[0].tension_n: -1 is not in [0, 1e6]. Give the tension in newtons."
[[nodiscard]] std::string to_text(const SceneProblem& problem);

/// True when one of them is more than a doubt.
[[nodiscard]] bool any_fault(const SceneProblems& problems) noexcept;

/// All that are more than doubts, as to_text() has them, a line each, without the end of the last.
[[nodiscard]] std::string faults_text(const SceneProblems& problems);

}  // namespace hapticd
