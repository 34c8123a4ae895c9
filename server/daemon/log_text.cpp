// See log_text.h.
#include "server/daemon/log_text.h"

#include <spdlog/spdlog.h>

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
  std::string line;
  std::size_t argument = 0;
  for (std::size_t i = 0; i < message.text.size(); ++i) {
    if (message.text[i] == '{' && i + 1 < message.text.size() && message.text[i + 1] == '}') {
      line += text_of(record.code, argument, record.arguments[argument]);
      ++argument;
      ++i;
    } else {
      line += message.text[i];
    }
  }
  switch (message.level) {
    case LogLevel::kInfo:
      spdlog::info("{}", line);
      break;
    case LogLevel::kWarning:
      spdlog::warn("{}", line);
      break;
    case LogLevel::kError:
      spdlog::error("{}", line);
      break;
  }
}

}  // namespace hapticd
