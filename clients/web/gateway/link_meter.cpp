// See link_meter.h.
#include "clients/web/gateway/link_meter.h"

#include <algorithm>

namespace hapticd::web {

void LinkMeter::take(const wire::DatagramHeader* header, std::size_t bytes) noexcept {
  bytes_ += bytes;
  total_bytes_ += bytes;
  if (header == nullptr) return;
  if (header->session != session_) {
    session_ = header->session;
    expected_ = next_ = header->counter;
    received_ = 0;
  }
  next_ = std::max(next_, header->counter + 1);
  ++received_;
}

LinkQuality LinkMeter::roll(std::int64_t now_ns) noexcept {
  LinkQuality quality;
  const std::uint64_t sent = next_ - expected_;
  if (sent > 0) {
    const double share = static_cast<double>(received_) / static_cast<double>(sent);
    quality.loss = std::clamp(1.0 - share, 0.0, 1.0);
  }
  const double seconds = static_cast<double>(now_ns - began_ns_) * 1e-9;
  if (began_ns_ != 0 && seconds > 0.0) quality.bytes_per_s = static_cast<double>(bytes_) / seconds;
  expected_ = next_;
  received_ = bytes_ = 0;
  began_ns_ = now_ns;
  return quality;
}

}  // namespace hapticd::web
