// See door.h.
#include "clients/web/gateway/door.h"

#include <algorithm>
#include <utility>

namespace hapticd::web {

using boost::asio::ip::address;

namespace {

/// Of IPv6 whoever has one address has the others of its /64.
address network_of(const address& from) {
  if (!from.is_v6() || from.is_loopback()) return from;
  auto bytes = from.to_v6().to_bytes();
  std::fill(bytes.begin() + bytes.size() / 2, bytes.end(), std::uint8_t{0});
  return boost::asio::ip::address_v6(bytes);
}

}  // namespace

bool Door::enter(const address& from, std::int64_t now_ns) {
  const auto elsewhere = [](const address& each) { return !each.is_loopback(); };
  // A proxy on this machine brings the pages of many.
  if (elsewhere(from)) {
    const address network = network_of(from);
    const auto held = held_.find(network);
    const auto same = [&](const address& each) { return network_of(each) == network; };
    if (held != held_.end() && held->second >= limits_.of_address && !make_place(same, now_ns)) {
      ++counters_.refused_address;
      return false;
    }
  }
  const std::size_t kept = elsewhere(from) ? limits_.connections / 4 : 0;
  const bool full = size_ >= limits_.connections ||
                    (elsewhere(from) && from_elsewhere_ + kept >= limits_.connections);
  if (full && !make_place(elsewhere, now_ns) && (elsewhere(from) || !make_place({}, now_ns))) {
    ++counters_.refused_full;
    return false;
  }
  ++size_;
  ++held_[network_of(from)];
  if (elsewhere(from)) ++from_elsewhere_;
  return true;
}

void Door::leave(const address& from) {
  const auto held = held_.find(network_of(from));
  if (held == held_.end()) return;
  --size_;
  if (!from.is_loopback()) --from_elsewhere_;
  if (--held->second == 0) held_.erase(held);
}

std::uint64_t Door::wait(const address& from, std::int64_t now_ns, std::function<void()> give_way) {
  return waiting_.add(from, now_ns, [this, from, give_way = std::move(give_way)] {
    leave(from);
    give_way();
  });
}

bool Door::make_place(const std::function<bool(const address&)>& of, std::int64_t now_ns) {
  if (!waiting_.evict(now_ns, of)) return false;
  ++counters_.evicted;
  return true;
}

}  // namespace hapticd::web
