// See heartbeats.h.
#include "server/stop_road/heartbeats.h"

#include <algorithm>

namespace hapticd {

Heartbeats::Entry* Heartbeats::find(std::uint64_t client) noexcept {
  for (Entry& entry : entries_) {
    if (entry.client == client) return &entry;
  }
  return nullptr;
}

Heartbeats::Entry* Heartbeats::place(std::int64_t now_ns) noexcept {
  for (Entry& entry : entries_) {
    if (entry.client == 0 || (!entry.needed && entry.until_ns < now_ns)) return &entry;
  }
  return nullptr;
}

Heartbeats::Verdict Heartbeats::beat(std::uint64_t client, std::uint64_t number,
                                     std::int64_t timeout_ns, std::int64_t now_ns) noexcept {
  Entry* entry = find(client);
  if (entry != nullptr && number <= entry->number) return Verdict::kRepeated;
  if (entry == nullptr) entry = place(now_ns);
  if (entry == nullptr) return Verdict::kFull;
  *entry = {client, number, true, now_ns + timeout_ns};
  return Verdict::kCounts;
}

Heartbeats::Verdict Heartbeats::leave(std::uint64_t client, std::uint64_t number,
                                      std::int64_t now_ns) noexcept {
  Entry* entry = find(client);
  if (entry == nullptr) return Verdict::kCounts;
  if (number <= entry->number) return Verdict::kRepeated;
  *entry = {client, number, false, now_ns + kGoneMemory_ns};
  return Verdict::kCounts;
}

void Heartbeats::forget_absent(std::int64_t now_ns) noexcept {
  for (Entry& entry : entries_) {
    if (!entry.needed || entry.until_ns >= now_ns) continue;
    entry.needed = false;
    entry.until_ns = now_ns + kGoneMemory_ns;
  }
}

std::size_t Heartbeats::count() const noexcept {
  return static_cast<std::size_t>(std::count_if(entries_.begin(), entries_.end(),
                                                [](const Entry& entry) { return entry.needed; }));
}

std::int64_t Heartbeats::earliest_ns(std::int64_t none) const noexcept {
  std::int64_t earliest_ns = none;
  for (const Entry& entry : entries_) {
    if (entry.needed) earliest_ns = std::min(earliest_ns, entry.until_ns);
  }
  return earliest_ns;
}

}  // namespace hapticd
