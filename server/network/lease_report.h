// What the log says of the lease: once a second, when it has changed. Pure: no clock, no log. Times
// are ns, never going back. Not RT.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "hapticd/v1/answer.pb.h"
#include "proto/wire/item_outbox.h"

namespace hapticd {

/// Shortest time between two reports, ns: a script takes and gives back the lease for each request.
inline constexpr std::int64_t kLeaseReport_ns = 1000 * wire::kMillisecond_ns;

class LeaseReport {
 public:
  /// Everyone was told this.
  void note(const v1::LeaseInfo& lease) {
    newest_ = text_of(lease);
    if (!lease.reason().empty()) taken_over_ = newest_;
    ++changes_;
  }

  /// "held by 'a'", "taken over by 'b' from 'a': reason", "free again, after 'b'"; the last
  /// take-over since the report before, too, where another has the lease by now. Empty when nothing
  /// has changed, or it is not yet time.
  std::string next(std::int64_t now_ns) {
    if (changes_ == 0 || now_ns < due_ns_) return {};
    due_ns_ = now_ns + kLeaseReport_ns;
    return rest();
  }

  /// The same at the end, whatever the time.
  std::string rest() {
    if (changes_ == 0) return {};
    std::string text = std::exchange(taken_over_, {});
    if (text != newest_) text += (text.empty() ? "" : "; then ") + newest_;
    if (changes_ > 1) text += " (" + std::to_string(changes_) + " changes)";
    changes_ = 0;
    return text;
  }

 private:
  std::string text_of(const v1::LeaseInfo& lease) {
    if (lease.fence() == 0) return "free again, after " + holder_;
    const std::string key = lease.key_name().empty() ? "" : " with the key " + lease.key_name();
    holder_ = "'" + lease.holder() + "'" + key;
    if (lease.reason().empty()) return "held by " + holder_;
    return "taken over by " + holder_ + " from '" + lease.taken_from() + "': " + lease.reason();
  }

  std::string holder_;  ///< of now, or the last one
  std::string newest_;
  std::string taken_over_;
  std::uint64_t changes_ = 0;
  std::int64_t due_ns_ = 0;
};

}  // namespace hapticd
