// See scene_problem.h.
#include "server/scene_io/scene_problem.h"

#include <algorithm>

#include "proto/wire/shown_text.h"

namespace hapticd {

std::string to_text(const SceneProblem& problem) {
  std::string text = problem.file;
  if (problem.line > 0) {
    text += ":" + std::to_string(problem.line) + ":" + std::to_string(problem.column);
  }
  if (!text.empty()) text += problem.doubt ? ": warning: " : ": error: ";
  if (!problem.field.empty()) text += problem.field + ": ";
  text += problem.message;
  if (!text.ends_with('.')) text += ".";
  if (!problem.remedy.empty()) text += " " + problem.remedy;
  // Both quote what the text says.
  return wire::shown_text(text);
}

bool any_fault(const SceneProblems& problems) noexcept {
  return std::any_of(problems.begin(), problems.end(),
                     [](const SceneProblem& problem) { return !problem.doubt; });
}

std::string faults_text(const SceneProblems& problems) {
  std::string text;
  for (const SceneProblem& problem : problems) {
    if (!problem.doubt) text += (text.empty() ? "" : "\n") + to_text(problem);
  }
  return text;
}

}  // namespace hapticd
