// A message in protobuf text format: parsed, with the place of each field remembered, so that what
// is found wrong later still names its line. Offline.
#pragma once

#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>

#include <string>
#include <string_view>
#include <utility>

#include "server/scene_io/scene_problem.h"

namespace hapticd {

/// Longest text, bytes: what fits into one blob of the protocol.
inline constexpr std::size_t kMaxText = 4'194'000;

/// Where the fields of a text are.
class MessageText {
 public:
  /// Parses `text`, which came from `file`, into `message`. What is not such a message is in
  /// problems(), where `what` says what was wanted: "scene".
  MessageText(std::string_view text, std::string file, std::string_view what,
              google::protobuf::Message& message);

  /// Empty when the text is such a message; its numbers may still be out of range.
  [[nodiscard]] const SceneProblems& problems() const noexcept { return problems_; }
  [[nodiscard]] const std::string& file() const noexcept { return file_; }

  /// `problem` with the file, and the line and column of its field; of the message it is missing in
  /// when it is not written.
  [[nodiscard]] SceneProblem located(SceneProblem problem) const;

 private:
  std::string file_;
  const google::protobuf::Descriptor* type_;
  google::protobuf::TextFormat::ParseInfoTree places_;
  SceneProblems problems_;
};

/// What `check` finds in the message that `text` is, its problems with their places.
template <typename Result, typename Message>
[[nodiscard]] Result check_text(std::string_view text, const std::string& file,
                                std::string_view what, Result (*check)(const Message&)) {
  Message message;
  const MessageText parsed(text, file, what, message);
  Result result;
  if (!any_fault(parsed.problems())) result = check(message);
  for (SceneProblem& problem : result.problems) problem = parsed.located(std::move(problem));
  result.problems.insert(result.problems.begin(), parsed.problems().begin(),
                         parsed.problems().end());
  return result;
}

}  // namespace hapticd
