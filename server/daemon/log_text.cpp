// See log_text.h.
#include "server/daemon/log_text.h"

#include <spdlog/spdlog.h>

#include <array>
#include <string>

#include "hapticd/v1/state.pb.h"

namespace hapticd {
namespace {

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
    return std::to_string(*whole);
  }
  if (const auto* real = std::get_if<double>(&argument)) return std::to_string(*real);
  return "";
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
  spdlog::log(level, "{}", fmt::format(fmt::runtime(message.text), a[0], a[1], a[2], a[3]));
}

}  // namespace hapticd
