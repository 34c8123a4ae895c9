// Log of the realtime path: the haptic thread pushes a plain record, a code and up to four numbers,
// into a ring; another thread pops it, looks up the text and formats. Nothing is formatted,
// written or allocated on the haptic thread. A new message is an enumerator and a row of
// kLogMessages. RT: make_log_record and the push yes; the table is plain data.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <variant>

#include "core/rt/spsc_ring.h"

namespace hapticd {

/// What happened. Values are positions in kLogMessages and may change between versions: they are
/// not stored.
enum class LogCode : std::uint16_t {
  kLoopStateChanged,
  kTickLate,
  kFaultLatched,
  kDeviceReadFailed,
  kDeviceWriteFailed,
  kRingOverflowed,
};

enum class LogLevel : std::uint8_t { kInfo, kWarning, kError };

/// Text and level of a code. Each {} takes one argument of the record, in order.
struct LogMessage {
  LogCode code;
  LogLevel level;
  std::string_view text;
};

/// Messages by code.
inline constexpr std::array kLogMessages{
    LogMessage{LogCode::kLoopStateChanged, LogLevel::kInfo, "loop state {} -> {}"},
    LogMessage{LogCode::kTickLate, LogLevel::kWarning,
               "up to tick {}: late by {} in all, {} skipped"},
    LogMessage{LogCode::kFaultLatched, LogLevel::kError, "fault {} latched at tick {}"},
    LogMessage{LogCode::kDeviceReadFailed, LogLevel::kWarning, "device read failed, errno {}"},
    LogMessage{LogCode::kDeviceWriteFailed, LogLevel::kWarning, "device write failed, errno {}"},
    LogMessage{LogCode::kRingOverflowed, LogLevel::kError, "ring {} full, {} items lost so far"},
};

/// The message of `code`.
[[nodiscard]] constexpr const LogMessage& message_of(LogCode code) noexcept {
  return kLogMessages[static_cast<std::size_t>(code)];
}

/// Number of arguments the message of `code` has a place for.
[[nodiscard]] constexpr std::size_t argument_count(LogCode code) noexcept {
  const std::string_view text = message_of(code).text;
  std::size_t count = 0;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) count += text[i] == '{' && text[i + 1] == '}';
  return count;
}

inline constexpr std::size_t kMaxLogArguments = 4;

/// One number of a record, or none.
using LogArgument = std::variant<std::monostate, std::int64_t, double>;

/// One line of the log, not yet formatted. `t_ns` on the monotonic clock.
struct LogRecord {
  std::int64_t t_ns = 0;
  LogCode code{};
  std::array<LogArgument, kMaxLogArguments> arguments{};
};
static_assert(std::is_trivially_copyable_v<LogRecord>);

/// Integers as int64, floating-point numbers as double.
template <typename Number>
[[nodiscard]] constexpr LogArgument to_log_argument(Number number) noexcept {
  static_assert(std::is_arithmetic_v<Number>);
  if constexpr (std::is_floating_point_v<Number>) {
    return static_cast<double>(number);
  } else {
    return static_cast<std::int64_t>(number);
  }
}

/// The record of message `Code` with its numbers, as many as its text has places.
template <LogCode Code, typename... Numbers>
[[nodiscard]] constexpr LogRecord make_log_record(std::int64_t t_ns, Numbers... numbers) noexcept {
  static_assert(sizeof...(Numbers) == argument_count(Code), "one number for each {} of the text");
  return {t_ns, Code, {to_log_argument(numbers)...}};
}

/// Records on their way out of the haptic thread: 1 s of one per tick.
using LogRing = SpscRing<LogRecord, 1024>;

static_assert(
    [] {
      for (std::size_t i = 0; i < kLogMessages.size(); ++i) {
        const LogCode code = kLogMessages[i].code;
        if (static_cast<std::size_t>(code) != i || argument_count(code) > kMaxLogArguments)
          return false;
      }
      return true;
    }(),
    "kLogMessages has one row per LogCode, in its order, with at most kMaxLogArguments places");

}  // namespace hapticd
