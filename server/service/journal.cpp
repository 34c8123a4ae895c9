// See journal.h.
// An entry's place in the source would be this file.
// NOLINTNEXTLINE(readability-identifier-naming): systemd's name
#define SD_JOURNAL_SUPPRESS_LOCATION
#include "server/service/journal.h"

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <systemd/sd-journal.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <mutex>

#include "proto/wire/shown_text.h"

namespace hapticd {
namespace {

/// Of syslog(3), which the journal has too.
int priority_of(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::trace:
    case spdlog::level::debug:
      return 7;
    case spdlog::level::warn:
      return 4;
    case spdlog::level::err:
      return 3;
    case spdlog::level::critical:
      return 2;
    default:
      return 6;
  }
}

/// Writes each line as an entry.
class JournalSink : public spdlog::sinks::base_sink<std::mutex> {
 public:
  void keep(std::string_view name, const std::string& value) {
    const std::lock_guard lock(mutex_);
    kept_[std::string(name)] = value;
  }

  void write(spdlog::level::level_enum level, std::string_view text,
             const std::vector<LogField>& fields) {
    const std::lock_guard lock(mutex_);
    send(level, text, fields);
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& line) override {
    send(line.level, {line.payload.data(), line.payload.size()}, {});
  }
  void flush_() override {}

 private:
  void send(spdlog::level::level_enum level, std::string_view text,
            const std::vector<LogField>& fields) const {
    std::vector<std::string> items{"MESSAGE=" + wire::shown_lines(std::string(text)),
                                   fmt::format("PRIORITY={}", priority_of(level)),
                                   "SYSLOG_IDENTIFIER=hapticd"};
    const auto add = [&](std::string_view name, const std::string& value) {
      items.push_back(fmt::format("{}={}", name, value));
    };
    for (const auto& [name, value] : kept_) add(name, value);
    for (const LogField& field : fields) add(field.name, field.value);
    std::vector<iovec> parts;
    parts.reserve(items.size());
    for (std::string& item : items) parts.push_back({item.data(), item.size()});
    if (sd_journal_sendv(parts.data(), static_cast<int>(parts.size())) < 0) {
      std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data());
    }
  }

  std::map<std::string, std::string> kept_;
};

/// That of the log; null: the log goes elsewhere.
JournalSink* journal_sink() {
  const auto& sinks = spdlog::default_logger_raw()->sinks();
  return sinks.empty() ? nullptr : dynamic_cast<JournalSink*>(sinks.front().get());
}

}  // namespace

bool stderr_is_journal() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing in this program changes the environment
  const char* const named = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (named == nullptr || ::fstat(STDERR_FILENO, &status) != 0) return false;
  return named == std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino);
}

void log_to_journal() {
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("hapticd", std::make_shared<JournalSink>()));
}

void keep_log_field(std::string_view name, const std::string& value) {
  if (JournalSink* const journal = journal_sink()) journal->keep(name, value);
}

void log_entry(spdlog::level::level_enum level, const std::string& text,
               const std::vector<LogField>& fields) {
  if (JournalSink* const journal = journal_sink()) {
    journal->write(level, text, fields);
  } else {
    spdlog::log(level, "{}", text);
  }
}

}  // namespace hapticd
