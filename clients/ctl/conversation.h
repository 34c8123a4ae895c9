// Talk with the person at the terminal while a session lives on: lines said, lines answered, an end
// asked for with Ctrl-C. Not RT.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "clients/ctl/connection.h"
#include "clients/library/client.h"

namespace hapticd::ctl {

/// Nobody answers any more: the input has ended.
struct InputEnded : Failure {
  using Failure::Failure;
};

/// The person a command talks with; in tests, a stand-in.
struct Conversation {
  std::function<void(const std::string&)> say;
  /// A line that was answered, without its end; none yet. Throws InputEnded when none can come.
  std::function<std::optional<std::string>()> answer;
  /// An end was asked for.
  std::function<bool()> ended;
};

/// stdout, stdin, and SIGINT and SIGTERM, which from now on only ask for an end.
[[nodiscard]] Conversation with_terminal();

/// Lets the session live until `done()`; false: not within `seconds`. Throws Failure when an end
/// was asked for, or the daemon has fallen silent.
bool live_until(client::Client& client, const Conversation& person,
                const std::function<bool()>& done, double seconds);

/// The person's next answer, however long it takes. Throws as live_until does.
[[nodiscard]] std::string next_answer(client::Client& client, const Conversation& person);

}  // namespace hapticd::ctl
