// What the log says of the lease.
#include "server/network/lease_report.h"

#include <doctest/doctest.h>

namespace hapticd::test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

v1::LeaseInfo lease(std::uint64_t fence, const std::string& holder) {
  v1::LeaseInfo info;
  info.set_fence(fence);
  info.set_holder(holder);
  return info;
}

TEST_CASE("the log names who holds the lease, with what key, and who gave it back") {
  LeaseReport report;
  CHECK(report.next(0).empty());
  v1::LeaseInfo named = lease(1, "page");
  named.set_key_name("desk");
  report.note(named);
  CHECK(report.next(0) == "held by 'page' with the key desk");
  CHECK(report.next(kSecond_ns).empty());
  report.note({});
  CHECK(report.next(2 * kSecond_ns) == "free again, after 'page' with the key desk");
}

TEST_CASE("a script that takes the lease for each request fills a line a second, not the log") {
  LeaseReport report;
  int lines = 0;
  for (std::int64_t k = 0; k < 1000; ++k) {
    report.note(lease(static_cast<std::uint64_t>(k) + 1, "script"));
    report.note({});
    if (!report.next(k * kSecond_ns / 100).empty()) ++lines;
  }
  CHECK(lines == 10);
}

TEST_CASE("a take-over is told with its reason, also where somebody else has the lease by then") {
  LeaseReport report;
  report.note(lease(1, "a"));
  v1::LeaseInfo taken = lease(2, "b");
  taken.set_taken_from("a");
  taken.set_reason("a has left");
  report.note(taken);
  report.note(lease(3, "c"));
  CHECK(report.next(0) == "taken over by 'b' from 'a': a has left; then held by 'c' (3 changes)");
}

}  // namespace
}  // namespace hapticd::test
