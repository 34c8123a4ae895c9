// See request_target.h.
#include "tests/fuzz/request_target.h"

#include <google/protobuf/stubs/logging.h>

#include <algorithm>

#include "proto/wire/request_rule.h"
#include "tests/fuzz/fuzzed_daemon.h"

namespace hapticd::test {
namespace {

/// Items in one input: more only cost time.
constexpr int kMaxItems = 12;

}  // namespace

bool check_requests(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return false;
  FuzzedDaemon daemon((bytes[0] & 1U) != 0);
  bytes = bytes.subspan(1);
  bool any_good = false;
  for (int n = 0; n < kMaxItems && bytes.size() >= 3; ++n) {
    for (unsigned k = 0; k < bytes[0] % 64U; ++k) daemon.pass();
    const std::size_t length = bytes[1] + 256U * bytes[2];
    bytes = bytes.subspan(3);
    const auto encoded = bytes.first(std::min(length, bytes.size()));
    bytes = bytes.subspan(encoded.size());
    v1::Item item;
    const google::protobuf::LogSilencer silence;
    if (!item.ParseFromArray(encoded.data(), static_cast<int>(encoded.size()))) continue;
    // What is no request ends the session; the datagrams' target does that.
    if (wire::rule_of(item) == nullptr) continue;
    any_good = daemon.ask(item) || any_good;
  }
  daemon.end();
  return any_good;
}

}  // namespace hapticd::test
