// See log_text.h.
#include "server/daemon/log_text.h"

#include <spdlog/spdlog.h>

#include <array>
#include <string>
#include <vector>

#include "hapticd/v1/state.pb.h"
#include "server/service/journal.h"

namespace hapticd {
namespace {

/// Of every fault, whatever its cause: `journalctl MESSAGE_ID=...`, sd_journal_send(3).
constexpr const char* kFaultMessageId = "36f95257ebf74360ab4b340fa32dbed9";

/// A time, three digits of it, in a unit in which it has few.
std::string time_text(std::int64_t ns) {
  const auto number = static_cast<double>(ns);
  if (ns < 1'000) return fmt::format("{} ns", ns);
  if (ns < 999'500) return fmt::format("{:.3g} us", number * 1e-3);
  if (ns < 999'500'000) return fmt::format("{:.3g} ms", number * 1e-6);
  return fmt::format("{:.1f} s", number * 1e-9);
}

/// Argument number `place`; states and causes by the names that clients see.
std::string text_of(LogCode code, std::size_t place, const LogArgument& argument) {
  if (const auto* whole = std::get_if<std::int64_t>(&argument)) {
    const int number = static_cast<int>(*whole);
    if (code == LogCode::kLoopStateChanged && v1::LoopState_IsValid(number)) {
      return v1::LoopState_Name(number).substr(std::string_view("LOOP_STATE_").size());
    }
    if (code == LogCode::kFaultLatched && place == 0 && v1::Cause_IsValid(number)) {
      return v1::Cause_Name(number).substr(std::string_view("CAUSE_").size());
    }
    if (code == LogCode::kTickLate && place == 1) return time_text(*whole);
    if (code == LogCode::kTickLate && place == 2) {
      return std::to_string(*whole) + (*whole == 1 ? " tick" : " ticks");
    }
    return std::to_string(*whole);
  }
  if (const auto* real = std::get_if<double>(&argument)) return std::to_string(*real);
  return "";
}

/// What happened, in one word, and what the argument at a place is called.
struct Fields {
  std::string_view event;
  std::array<std::string_view, kMaxLogArguments> arguments;
};

/// Fields by which entries of the journal are found.
const Fields& fields_of(LogCode code) {
  static constexpr std::array<Fields, kLogMessages.size()> kFields{{
      {"loop_state", {"", "HAPTICD_STATE"}},
      {"late", {"HAPTICD_TICK"}},
      {"fault", {"HAPTICD_FAULT", "HAPTICD_TICK"}},
      {"device_read", {"ERRNO"}},
      {"device_write", {"ERRNO"}},
      {"ring_full", {}},
  }};
  return kFields[static_cast<std::size_t>(code)];
}

}  // namespace

void write_log(const LogRecord& record) {
  const LogMessage& message = message_of(record.code);
  std::array<std::string, kMaxLogArguments> a;
  for (std::size_t k = 0; k < a.size(); ++k) a[k] = text_of(record.code, k, record.arguments[k]);
  const spdlog::level::level_enum level = message.level == LogLevel::kInfo ? spdlog::level::info
                                          : message.level == LogLevel::kWarning
                                              ? spdlog::level::warn
                                              : spdlog::level::err;
  const Fields& named = fields_of(record.code);
  std::vector<LogField> fields{{"HAPTICD_EVENT", std::string(named.event)}};
  if (record.code == LogCode::kFaultLatched) fields.push_back({"MESSAGE_ID", kFaultMessageId});
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (!named.arguments[k].empty()) fields.push_back({named.arguments[k], a[k]});
  }
  log_entry(level, fmt::format(fmt::runtime(message.text), a[0], a[1], a[2], a[3]), fields);
}

}  // namespace hapticd
