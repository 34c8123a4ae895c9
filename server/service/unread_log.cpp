// See unread_log.h.
#include "server/service/unread_log.h"

#include <poll.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "proto/wire/shown_text.h"

namespace hapticd {
namespace {

/// What is kept of a line, bytes. A pipe that is ready takes PIPE_BUF, 4096, at once, and time,
/// level and colours are written before.
constexpr std::size_t kLongest = 3000;

bool takes_a_line() {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  // Hung up: writing fails at once, which is no waiting.
  return ::poll(&out, 1, 0) == 1;
}

/// Passes lines on to another sink while that would not have to wait.
class UnreadLog : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit UnreadLog(std::shared_ptr<spdlog::sinks::sink> out) : out_(std::move(out)) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& line) override {
    if (lost_ > 0 && takes_a_line()) {
      const std::string told = fmt::format("{} lines of the log are lost: nobody read it", lost_);
      out_->log({line.time, spdlog::source_loc{}, line.logger_name, spdlog::level::warn, told});
      lost_ = 0;
    }
    if (!takes_a_line()) {
      ++lost_;
      return;
    }
    spdlog::details::log_msg cut = line;
    const std::string shown =
        wire::shown_lines({line.payload.data(), std::min(line.payload.size(), kLongest)});
    cut.payload = {shown.data(), std::min(shown.size(), kLongest)};
    out_->log(cut);
  }
  void flush_() override {
    if (takes_a_line()) out_->flush();
  }
  void set_pattern_(const std::string& pattern) override { out_->set_pattern(pattern); }
  void set_formatter_(std::unique_ptr<spdlog::formatter> formatter) override {
    out_->set_formatter(std::move(formatter));
  }

 private:
  std::shared_ptr<spdlog::sinks::sink> out_;
  std::uint64_t lost_ = 0;
};

}  // namespace

void log_without_waiting() {
  const auto out = std::make_shared<spdlog::sinks::stdout_color_sink_mt>();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("", std::make_shared<UnreadLog>(out)));
}

}  // namespace hapticd
