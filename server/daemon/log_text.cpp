// See log_text.h.
#include "server/daemon/log_text.h"

#include <spdlog/spdlog.h>

#include <string>

namespace hapticd {
namespace {

std::string text_of(const LogArgument& argument) {
  if (const auto* whole = std::get_if<std::int64_t>(&argument)) return std::to_string(*whole);
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
      line += text_of(record.arguments[argument++]);
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
