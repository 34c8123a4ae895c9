// Log records: what goes in on the haptic thread comes out on the other side, and every code has
// its text.
#include "core/rt/rt_log.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>
#include <variant>

#include "tests/support/no_heap.h"

namespace {

using namespace hapticd;

}  // namespace

TEST_CASE("a log record keeps time, code and numbers of both kinds through the ring") {
  const auto ring = std::make_unique<LogRing>();
  const std::int64_t longest = std::numeric_limits<std::int64_t>::max();
  ring->push(make_log_record<LogCode::kTickLate>(17, longest, -3, 2U));
  ring->push(make_log_record<LogCode::kLoopStateChanged>(18, 1.5, 2.5F));

  LogRecord record;
  CHECK(ring->pop(record));
  CHECK(record.t_ns == 17);
  CHECK(record.code == LogCode::kTickLate);
  CHECK(record.arguments[0] == LogArgument{longest});
  CHECK(record.arguments[1] == LogArgument{std::int64_t{-3}});
  CHECK(record.arguments[2] == LogArgument{std::int64_t{2}});
  CHECK(std::holds_alternative<std::monostate>(record.arguments[3]));

  CHECK(ring->pop(record));
  CHECK(record.code == LogCode::kLoopStateChanged);
  CHECK(record.arguments[0] == LogArgument{1.5});
  CHECK(record.arguments[1] == LogArgument{2.5});
  CHECK(std::holds_alternative<std::monostate>(record.arguments[2]));
}

TEST_CASE("every log message has its code, a text of its own and places for at most four numbers") {
  for (const LogMessage& message : kLogMessages) {
    CHECK(message_of(message.code).code == message.code);
    CHECK_FALSE(message.text.empty());
    for (const LogMessage& other : kLogMessages) {
      CHECK((message.code == other.code) == (message.text == other.text));
    }
    std::size_t places = 0;
    for (std::size_t at = message.text.find("{}"); at != std::string_view::npos;
         at = message.text.find("{}", at + 2)) {
      ++places;
    }
    CHECK(places == argument_count(message.code));
    CHECK(places <= kMaxLogArguments);
  }
}

TEST_CASE("making and pushing a log record does not touch the heap") {
  const auto ring = std::make_unique<LogRing>();
  const hapticd::test::NoHeapScope scope;
  for (int i = 0; i < 2000; ++i) ring->push(make_log_record<LogCode::kTickLate>(i, i, 1.0, 2));
  const std::int64_t heap_calls = scope.count();
  CHECK(heap_calls == 0);
  CHECK(ring->overflow() == 2000 - LogRing::capacity());
}
