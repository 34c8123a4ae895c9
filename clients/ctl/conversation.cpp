// See conversation.h.
#include "clients/ctl/conversation.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <limits>

#include "clients/ctl/connection.h"
#include "clients/ctl/text.h"

namespace hapticd::ctl {
namespace {

/// Silence after which the daemon counts as gone, s: its states come far more often.
constexpr double kSilence = 3.0;

std::atomic<bool> over{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void end_all(int /*signal*/) { over.store(true); }

/// Lines of stdin, taken without waiting.
class Lines {
 public:
  std::optional<std::string> next() {
    std::optional<std::string> line = cut();
    if (line) return line;
    pollfd wanted{STDIN_FILENO, POLLIN, 0};
    if (::poll(&wanted, 1, 0) <= 0) return std::nullopt;
    std::array<char, 256> bytes{};
    const ssize_t count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
    if (count > 0) {
      buffer_.append(bytes.data(), static_cast<std::size_t>(count));
    } else if (count == 0) {
      throw InputEnded(kRefused, "nobody answers: the input has ended. Run this at a terminal");
    }
    return cut();
  }

 private:
  std::optional<std::string> cut() {
    const std::size_t end = buffer_.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string line = buffer_.substr(0, end);
    buffer_.erase(0, end + 1);
    return line;
  }

  std::string buffer_;
};

}  // namespace

Conversation with_terminal() {
  std::signal(SIGINT, end_all);
  std::signal(SIGTERM, end_all);
  Conversation person;
  person.say = [](const std::string& text) {
    print_lines(text);
    std::fflush(stdout);
  };
  person.answer = [lines = std::make_shared<Lines>()] { return lines->next(); };
  person.ended = [] { return over.load(); };
  return person;
}

bool live_until(client::Client& client, const Conversation& person,
                const std::function<bool()>& done, double seconds) {
  const std::int64_t began_ns = client::monotonic_now_ns();
  const auto since = [](std::int64_t ns) {
    return 1e-9 * static_cast<double>(client::monotonic_now_ns() - ns);
  };
  while (true) {
    if (person.ended()) throw Failure(kRefused, "ended before it was done");
    if (done()) return true;
    if (since(began_ns) >= seconds) return false;
    client.poll();
    const std::int64_t heard_ns = client.core().heard_ns();
    if (since(heard_ns != 0 ? heard_ns : began_ns) > kSilence) {
      throw Failure(kUnreachable,
                    "hapticd no longer answers. It takes its force away 2 s "
                    "after it has lost this session");
    }
  }
}

std::string next_answer(client::Client& client, const Conversation& person) {
  std::optional<std::string> line;
  static_cast<void>(live_until(
      client, person,
      [&] {
        line = person.answer();
        return line.has_value();
      },
      std::numeric_limits<double>::infinity()));
  return *line;
}

}  // namespace hapticd::ctl
